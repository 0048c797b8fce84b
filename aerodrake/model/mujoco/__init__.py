"""The vehicle's dynamics in MuJoCo, a second physics engine."""
