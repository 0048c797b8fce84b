"""Reference position and direction of the end-effector."""
