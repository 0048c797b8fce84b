"""ESO flight controller and joint PID."""
