"""Accelerometer, and the random walk of an inertial sensor's bias."""

import numpy as np

from aerodrake.model.vehicle.rotation import apply, rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


@compiled
def specific_force(before: np.ndarray, now: np.ndarray, dt: float) -> np.ndarray:
    """Returns the mean specific force (3,) m/s^2 of the base's origin, in the base frame.

    The acceleration is the mean over `dt`, and so is the rotation from the world, that of both
    ends: R^T (a + g e_z).

    Args:
        before, now: (13 + 2 n,) states at both ends.
        dt: s, time between them.
    """
    last, state = split_state(before), split_state(now)
    force = (state.v_B - last.v_B) / dt
    force[2] += GRAVITY
    R_mean = (rotation_matrix(last.quaternion) + rotation_matrix(state.quaternion)) / 2
    return apply(R_mean.T, force)


@compiled
def walked(bias: np.ndarray, drift: float, noise: np.ndarray, dt: float) -> np.ndarray:
    """Returns a bias (3,) after a step of its random walk.

    Its variance grows by drift^2 each second.

    Args:
        bias: (3,) before.
        drift: Standard deviation per square root of 1 s.
        noise: (3,) standard normal draws.
        dt: s, of the step.
    """
    return bias + drift * np.sqrt(dt) * noise
