"""Bounds of a scaled quadratic program: |z| <= 1 and lower <= A z <= upper."""

import numpy as np

from aerodrake.model.qp.banded_rows import BandedRows, row_dot
from aerodrake.support.compiled import compiled

FEASIBILITY = 1e-6
"""Largest violation of a scaled bound at which the unconstrained minimiser is the solution."""


@compiled
def is_within(A: BandedRows, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    """Returns True if z (nz,) is in its box and A z within `lower` and `upper` (rows,).

    Returns False if a value is NaN.
    """
    for x in z:
        if not abs(x) <= 1 + FEASIBILITY:
            return False
    for i in range(len(lower)):
        x = row_dot(A, i, z)
        if not (lower[i] - FEASIBILITY <= x <= upper[i] + FEASIBILITY):
            return False
    return True


@compiled
def without_redundant(
    lower: np.ndarray, upper: np.ndarray, reach: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns (lower, upper) with infinite bounds for redundant constraints.

    Args:
        lower, upper: (rows,).
        reach: (rows,), largest |A z| of z in its box.
    """
    return np.where(lower <= -reach, -np.inf, lower), np.where(upper >= reach, np.inf, upper)


@compiled
def violated(z: np.ndarray, Az: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Returns (nz + rows,): 1 where an upper bound is violated, -1 a lower one, else 0.

    Args:
        z: (nz,), in a box of +-1.
        Az: (rows,), A z.
        lower, upper: (rows,), bounds of A z.
    """
    sides = np.zeros(len(z) + len(Az), dtype=np.int64)
    for i in range(len(z)):
        if abs(z[i]) > 1 + FEASIBILITY:
            sides[i] = 1 if z[i] > 0 else -1
    for i in range(len(Az)):
        if Az[i] > upper[i] + FEASIBILITY:
            sides[len(z) + i] = 1
        elif Az[i] < lower[i] - FEASIBILITY:
            sides[len(z) + i] = -1
    return sides
