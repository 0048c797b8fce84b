"""Strictly convex quadratic programs in scaled variables."""

from typing import NamedTuple

import numpy as np


class QuadraticProgram(NamedTuple):
    """min z^T H z / 2 + g^T z subject to |z| <= 1 and lower <= A z <= upper.

    Attributes:
        H: (nz, nz), symmetric and positive definite, C-contiguous.
        g: (nz,).
        A: (rows, nz), rows of unit norm.
        lower, upper: (rows,); infinite where there is no bound.
    """

    H: np.ndarray
    g: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
