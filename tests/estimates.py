"""States, and what the state filter makes of a sample of one."""

import numpy as np

from aerodrake.model.sensing.state_filter import (
    StateFilter,
    correct_joints,
    correct_motion,
    correct_rotation,
)
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Filter

DT = 0.01
JOINTS = 6
CONFIG = Filter(
    position_noise_m=0.002,
    velocity_noise_m_s=0.05,
    attitude_noise_rad=0.004,
    rate_noise_rad_s=0.02,
    disturbance_m_s3=40.0,
    disturbance_rad_s3=7.0,
)
"""Of noise and disturbances that make a fast filter, so that few samples tell much."""


def rest(**parts: np.ndarray) -> VehicleState:
    """At the origin and upright, but for `parts`."""
    zero = split_state(np.zeros(VehicleState.size(JOINTS)))
    return zero._replace(**{"quaternion": np.array([1.0, 0, 0, 0]), **parts})


def estimate(d=(0, 0, 0), delta=(0, 0, 0), **parts: np.ndarray) -> np.ndarray:
    """(19 + 2 n,)"""
    return np.concatenate([d, delta, rest(**parts).to_vector()])


def correct(gains: StateFilter, predicted: np.ndarray, sample: np.ndarray) -> np.ndarray:
    """(19 + 2 n,) the estimate at a sample's own time, with all groups taken in."""
    found = predicted.copy()
    for group in (correct_motion, correct_rotation, correct_joints):
        group(gains, found, sample)
    return found


def state_of(estimate: np.ndarray) -> VehicleState:
    return split_state(estimate[6:])
