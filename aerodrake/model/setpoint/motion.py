"""Prescribed motions of setpoints, quadratic in each period as those of the MPC."""

import numpy as np
from pydrake.trajectories import PiecewisePolynomial


def held_acceleration_motion(
    start: np.ndarray, velocity: np.ndarray, period: float
) -> PiecewisePolynomial:
    """Returns a motion whose acceleration is constant in each period.

    Args:
        start: (m,) initial position.
        velocity: (T, m) at the times 0, period, 2 period, ...; linear in between.
        period: s.

    Returns:
        Position (m,) over [0, (T - 1) period].
    """
    moved = np.cumsum((velocity[1:] + velocity[:-1]) * (period / 2), axis=0)
    position = start + np.vstack([np.zeros_like(velocity[:1]), moved])
    times = period * np.arange(len(velocity))
    # The cubic terms vanish: positions are the integrals of the velocities.
    return PiecewisePolynomial.CubicHermite(times, position.T, velocity.T)
