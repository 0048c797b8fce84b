"""Results of quadratic programs."""

from enum import IntEnum
from typing import NamedTuple, Self

import numpy as np


class QpStatus(IntEnum):
    """Outcome of solving a program, best first; from INFEASIBLE on there is no solution.

    UNCONSTRAINED: exact, the unconstrained minimiser.
    SOLVED: exact, the optimality conditions of the solver's active set were verified.
    INACCURATE: the solver's iterate, with small residuals.
    SOFTENED: exact or inaccurate, with the least violation of custom constraints.
    RELAXED: exact or inaccurate for widened bounds; with the given ones there was no solution.
    INFEASIBLE: no z satisfies all bounds.
    ITERATION_LIMIT: the solver ended without a solution, mostly by its iteration limit.
    NON_FINITE: an input is NaN or infinite, or H is not positive definite.
    """

    UNCONSTRAINED = 0
    SOLVED = 1
    INACCURATE = 2
    SOFTENED = 3
    RELAXED = 4
    INFEASIBLE = 5
    ITERATION_LIMIT = 6
    NON_FINITE = 7


def is_solved(status: float) -> bool:
    """Returns True if a program with this status has a solution."""
    return status <= QpStatus.RELAXED


class QpResult(NamedTuple):
    """Solution of one program.

    Attributes:
        z: (nz,), the minimiser; zeros without a solution.
        status: A `QpStatus`.
        iterations: Iterations of the solver; 0 if none was called.
    """

    z: np.ndarray
    status: int
    iterations: int = 0

    @classmethod
    def without_solution(cls, nz: int, status: QpStatus, iterations: int = 0) -> Self:
        """Returns the result of a program of nz variables that is not solved."""
        return cls(np.zeros(nz), status, iterations)
