"""Prescribed motions of the setpoints, in the form the setpoint integrator gives them."""

from __future__ import annotations

import numpy as np
from pydrake.trajectories import PiecewisePolynomial


def held_acceleration_motion(
    start: np.ndarray, velocity: np.ndarray, period: float
) -> PiecewisePolynomial:
    """A motion whose acceleration is held over each period, as the MPC's is.

    Args:
        start: (m,) where it starts.
        velocity: (T, m) at the times 0, period, 2 period, ...; linear in between.
        period: s.

    Returns:
        (m,) position over [0, (T - 1) period], quadratic in each period.
    """
    moved = np.cumsum((velocity[1:] + velocity[:-1]) * (period / 2), axis=0)
    position = start + np.vstack([np.zeros_like(velocity[:1]), moved])
    times = period * np.arange(len(velocity))
    # The cubic terms vanish, since the positions are the integrals of the velocities.
    return PiecewisePolynomial.CubicHermite(times, position.T, velocity.T)
