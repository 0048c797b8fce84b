"""Estimates and their corrections, for tests of the state filter."""

import numpy as np

from aerodrake.model.sensing.estimate import (
    Estimate,
    correct_attitude,
    correct_joints,
    correct_position,
)
from aerodrake.model.sensing.state_filter import StateFilter
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
"""Noise and disturbances of a fast filter, which converges within few samples."""


def rest(**parts: np.ndarray) -> VehicleState:
    """Returns the state at rest, upright at the origin, but for `parts`."""
    zero = split_state(np.zeros(VehicleState.size(JOINTS)))
    return zero._replace(**{"quaternion": np.array([1.0, 0, 0, 0]), **parts})


def estimate(d=(0, 0, 0), delta=(0, 0, 0), **parts: np.ndarray) -> Estimate:
    """Returns the estimate with disturbances d and delta, otherwise as `rest`."""
    return Estimate(np.array([*d, *delta], float), rest(**parts).to_vector())


def correct(gains: StateFilter, predicted: Estimate, sample: np.ndarray) -> Estimate:
    """Returns the estimate at a sample's own time, corrected by all its groups."""
    corrected = Estimate(*(field.copy() for field in predicted))
    correct_position(corrected, sample, gains.translation)
    correct_attitude(corrected, sample, gains.rotation)
    correct_joints(corrected, sample, gains.joint, gains.dt)
    return corrected


def state_of(estimate: Estimate) -> VehicleState:
    """Returns the parts of an estimate's state."""
    return split_state(estimate.state)
