"""What a tick, a flight and a start cost, beside other solvers."""
