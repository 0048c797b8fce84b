"""Conversion of an arm's own URDF into one that flies below a multirotor."""
