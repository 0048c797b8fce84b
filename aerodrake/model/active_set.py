"""Exact solution of a quadratic program from a guess of which bounds are active."""

from __future__ import annotations

import numpy as np
from scipy.linalg import cho_solve
from scipy.linalg.lapack import dposv

MAX_EXCHANGES = 25
TOLERANCE = 1e-9
"""By how much a bound may be exceeded that is not active."""

MET = 1e-7
"""How far off an active bound may be."""


def exchange_active_set(
    factor: tuple[np.ndarray, bool],
    free: np.ndarray,
    A: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    prices: np.ndarray,
) -> np.ndarray | None:
    """The minimiser of z' H z / 2 + g' z with lower <= A z <= upper, or None.

    The primal-dual active set method (Hintermueller, Ito and Kunisch 2002):
    bounds of the guess are taken as equalities; those that others imply or whose
    multiplier pulls the wrong way are let go, those that are violated are taken
    in, until nothing changes. Then the conditions of optimality hold, and z is
    the solution. It may not come to that, for which there is None.

    Args:
        factor: Cholesky factor of H (nz, nz), as from `scipy.linalg.cho_factor`.
        free: (nz,), the unconstrained minimiser.
        A: (rows, nz).
        lower, upper: (rows,).
        prices: (rows,), a guess of how the cost changes with each active bound:
            negative for upper bounds, positive for lower ones, near 0 for others.
    """
    clear = 1e-3 * np.abs(prices).max(initial=0.0)
    above, below = prices < -clear, prices > clear
    for _ in range(MAX_EXCHANGES):
        active = np.flatnonzero(above | below)
        rows = A[active]
        bound = np.where(above, upper, lower)[active]
        influence = cho_solve(factor, rows.T, check_finite=False)
        multiplier, dependent = np.zeros(0), 0
        if len(active):
            _, multiplier, dependent = dposv(rows @ influence, rows @ free - bound)
        if dependent:  # The order of the first row that the ones before it imply.
            above[active[dependent - 1]] = below[active[dependent - 1]] = False
            continue
        z = free - influence @ multiplier
        value = A @ z
        now_above, now_below = value > upper + TOLERANCE, value < lower - TOLERANCE
        now_above[active] |= above[active] & (multiplier > 0)
        now_below[active] |= below[active] & (multiplier < 0)
        if (now_above == above).all() and (now_below == below).all():
            # More active rows than z can meet make the multipliers meaningless.
            return z if np.abs(value[active] - bound).max(initial=0.0) < MET else None
        above, below = now_above, now_below
    return None
