"""Double integration of u to setpoints."""
