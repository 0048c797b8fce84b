"""Flight controller with extended state observers (ESO), and joint PID controller."""
