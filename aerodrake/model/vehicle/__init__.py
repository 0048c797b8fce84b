"""The robot and its physics: kinematics, whole-body dynamics, payload, wind."""
