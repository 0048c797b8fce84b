"""The vehicle: robot description, kinematics, dynamics, payload and wind."""
