"""Setpoints of trim."""

import numpy as np


def hovering(vehicle):
    """(base setpoint, joint setpoint) of trim."""
    n = vehicle.joints
    return np.r_[vehicle.p_B, np.zeros(6)], np.r_[vehicle.working, np.zeros(2 * n)]
