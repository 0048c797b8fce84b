"""Strictly convex quadratic programs in scaled variables."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np
from scipy.linalg.lapack import dpotrf, dpotrs

from aerodrake.model.qp.result import QpStatus

FEASIBILITY = 1e-6
"""Largest violation of a bound by a solution."""


@dataclass(frozen=True, eq=False)
class QuadraticProgram:
    """min z^T H z / 2 + g^T z subject to |z| <= 1 and lower <= A z <= upper.

    Attributes:
        H: (nz, nz), symmetric and positive definite, C-contiguous.
        g: (nz,).
        A: (rows, nz), rows of unit norm or zero.
        lower, upper: (rows,); infinite where there is no bound.
    """

    H: np.ndarray
    g: np.ndarray
    A: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @cached_property
    def factor(self) -> np.ndarray | None:
        """Lower Cholesky factor L (nz, nz) of H; None unless H is finite and positive definite.

        The elements above the diagonal are undefined.
        """
        # H is symmetric: its transpose has LAPACK's order without a copy.
        factor, is_indefinite = dpotrf(self.H.T, lower=1, clean=0)
        is_finite = np.isfinite(factor.diagonal()).all()
        return None if is_indefinite or not is_finite else factor

    @cached_property
    def minimiser(self) -> np.ndarray:
        """The unconstrained minimiser (nz,); NaN without a Cholesky factor."""
        if self.factor is None:
            return np.full_like(self.g, np.nan)
        return dpotrs(self.factor, -self.g, lower=1)[0]

    @property
    def scale(self) -> float:
        """Mean diagonal element of H."""
        return float(self.H.diagonal().mean())

    def is_feasible(self, z: np.ndarray) -> bool:
        """Returns True if z (nz,) satisfies all bounds up to `FEASIBILITY`; False if it is NaN."""
        if not np.abs(z).max() <= 1 + FEASIBILITY:
            return False
        rows, slack = self.A @ z, FEASIBILITY
        return bool(((rows >= self.lower - slack) & (rows <= self.upper + slack)).all())

    def defect(self) -> QpStatus | None:
        """Returns why the program cannot be solved: NON_FINITE, INFEASIBLE, or None."""
        numbers = self.minimiser.sum() + self.A.sum()
        if not np.isfinite(numbers) or np.isnan(self.lower).any() or np.isnan(self.upper).any():
            return QpStatus.NON_FINITE
        is_empty = (self.lower > self.upper) | (self.lower == np.inf) | (self.upper == -np.inf)
        return QpStatus.INFEASIBLE if is_empty.any() else None


class Constraints(NamedTuple):
    """Bounds lower <= N z <= upper of a program: those of z first, then those of its rows.

    Attributes:
        N: (nc, nz), rows of unit norm or zero; the first nz are the identity.
        lower, upper: (nc,).
    """

    N: np.ndarray
    lower: np.ndarray
    upper: np.ndarray

    @classmethod
    def of(cls, program: QuadraticProgram) -> Self:
        """Returns the constraints without the redundant rows, which no |z| <= 1 violates."""
        A, lower, upper = program.A, program.lower, program.upper
        reach = np.abs(A).sum(axis=1)
        needed = (lower > -reach) | (upper < reach)
        ones = np.ones(A.shape[1])
        return cls(
            np.vstack([np.eye(len(ones)), A[needed]]),
            np.concatenate([-ones, lower[needed]]),
            np.concatenate([ones, upper[needed]]),
        )

    def violations(self, z: np.ndarray) -> np.ndarray:
        """Returns (nc,), by how much z (nz,) exceeds each upper or lower bound, if positive."""
        return violations(self.N @ z, self.lower, self.upper)


def violations(values: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    """Returns (k,), by how much values (k,) exceed each upper or lower bound (k,), if positive."""
    return np.maximum(values - upper, lower - values)
