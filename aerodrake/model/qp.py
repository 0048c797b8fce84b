"""A condensed, scaled quadratic program, built once and solved at every tick."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolverOptions
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtri

from aerodrake.compiled import compiled
from aerodrake.model.active_set import exchange_active_set
from aerodrake.model.banded_rows import BandedRows, row_dot, rows_dot

FEASIBILITY = 1e-6
"""By how much the unconstrained minimiser may exceed a scaled bound and still be the solution."""

MOST_EXCHANGES = 100
"""How many bounds may be exchanged before OSQP is asked."""

ACCEPTED_RESIDUAL = 1e-3
"""Largest scaled OSQP residual with which an iterate counts as an answer."""


class QpStatus(IntEnum):
    """How the answer came about, best first.

    UNCONSTRAINED, EXCHANGED and SOLVED are exact: the conditions of optimality were
    checked. The active bounds of EXCHANGED were found from those of the tick before or, if
    it had none, from those that the unconstrained minimiser violates; those of SOLVED from
    OSQP's iterate. INACCURATE is such an iterate with small residuals.
    """

    UNCONSTRAINED = 0
    EXCHANGED = 1
    SOLVED = 2
    INACCURATE = 3
    FAILED = 4


def is_bound(status: float) -> bool:
    """Whether bounds hold the answer, and which they are is known."""
    return QpStatus.UNCONSTRAINED < status < QpStatus.FAILED


class QpResult(NamedTuple):
    """The answer to one program.

    Attributes:
        z: (nz,) the minimiser; zeros if it failed.
        status: How it came about.
        iterations: Of OSQP; 0 where it was not needed.
        active: (nz + rows,) which bounds hold z, those of the box first: 1 for upper,
            -1 for lower, 0 for none.
    """

    z: np.ndarray
    status: QpStatus
    iterations: int
    active: np.ndarray


class CondensedQp:
    """min z' H z / 2 + g' z  subject to  |z| <= 1,  lower <= A z <= upper.

    Scaled by the caller: z by the input bounds, the rows of A to unit norm. A
    stays, the rest changes from call to call. What makes it fast and exact:

    1. The unconstrained minimiser is the solution whenever it satisfies every bound.
    2. Rows that no z in the box can violate are screened out.
    3. Bounds that were active a tick ago mostly still are: a few exchanges of
       `exchange_active_set` make them those of this program.
    4. Else OSQP's iterate, of the cost scaled by its mean diagonal, tells which they are.

    Where not even that makes it exact, the iterate counts if its residuals are small.

    Args:
        A: (rows, nz), rows of unit norm.
        max_iterations: Of OSQP. A limit in iterations keeps flights
            repeatable, where one in seconds would not.
    """

    def __init__(self, A: np.ndarray, max_iterations: int):
        rows, nz = A.shape
        self.A = A
        self._banded = BandedRows.of(A)
        self._unbound = np.zeros(nz + rows, dtype=np.int64)
        self._reach = np.abs(A).sum(axis=1)
        self._program = MathematicalProgram()
        z = self._program.NewContinuousVariables(nz, "z")
        self._cost = self._program.AddQuadraticCost(np.eye(nz), np.zeros(nz), z, is_convex=True)
        self._box = self._program.AddBoundingBoxConstraint(-1.0, 1.0, z)
        unbounded = np.full(rows, np.inf)
        self._rows = self._program.AddLinearConstraint(A, -unbounded, unbounded, z)
        self._solver = OsqpSolver()
        options = SolverOptions()
        for name, value in {
            "scaling": 0,
            "rho": 0.03,
            "adaptive_rho_interval": 25,
            "check_termination": 25,
            "eps_abs": 1e-5,
            "eps_rel": 1e-5,
            "polishing": 0,
            "max_iter": max_iterations,
        }.items():
            options.SetOption(self._solver.id(), name, value)
        self._options = options
        # What is compiled is loaded now, and not at the first tick that a bound holds.
        self.solve(np.eye(nz), -2.0 * np.eye(nz)[0], -unbounded, unbounded)

    def solve(
        self,
        H: np.ndarray,
        g: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        active: np.ndarray | None = None,
    ) -> QpResult:
        """Solves one program.

        Args:
            H: (nz, nz), symmetric and positive definite, row by row in memory.
            g: (nz,).
            lower, upper: (rows,).
            active: (nz + rows,), those of a similar program; without, or where none
                were, the bounds that the unconstrained minimiser violates.
        """
        # Symmetric: the transpose, as LAPACK wants it, is the same without a copy.
        factor, is_indefinite = dpotrf(H.T, lower=1, clean=0)
        if is_indefinite or not np.isfinite(factor.diagonal()).all():
            return self._failed(0)
        free, _ = dpotrs(factor, -g, lower=1)
        if (result := self.accepted(free, lower, upper)) is not None:
            return result
        if not np.isfinite(free).all() or np.isnan(lower).any() or np.isnan(upper).any():
            return self._failed(0)
        lower, upper = screened(lower, upper, self._reach)
        if active is None or not active.any():
            active = violations(free, rows_dot(self._banded, free), lower, upper)
        inverse = np.triu(dtrtri(factor, lower=1)[0].T)
        is_exact, z, held = exchange_active_set(
            inverse, free, self._banded, lower, upper, active, MOST_EXCHANGES
        )
        if is_exact:
            return QpResult(z.clip(-1, 1), QpStatus.EXCHANGED, 0, held)
        return self._by_osqp(H, g, lower, upper, inverse, free)

    def accepted(self, free: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> QpResult | None:
        """The unconstrained minimiser (nz,) as the answer, if it keeps all bounds."""
        if not is_within(self._banded, free, lower, upper):
            return None
        return QpResult(free.clip(-1, 1), QpStatus.UNCONSTRAINED, 0, self._unbound)

    def _by_osqp(
        self,
        H: np.ndarray,
        g: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        inverse: np.ndarray,
        free: np.ndarray,
    ) -> QpResult:
        scale = 1 / np.diag(H).mean()
        self._cost.evaluator().UpdateCoefficients(H * scale, g * scale, 0, True)
        self._rows.evaluator().set_bounds(lower, upper)
        result = self._solver.Solve(self._program, None, self._options)
        details = result.get_solver_details()
        z = result.get_x_val()
        # An infeasible program comes back with a z that is huge, but finite.
        if not (np.isfinite(z).all() and np.abs(z).max() < 2):
            return self._failed(details.iter)
        prices = np.concatenate(
            [result.GetDualSolution(self._box), result.GetDualSolution(self._rows)]
        )
        clear = np.abs(prices) > 1e-3 * np.abs(prices).max(initial=0.0)
        guess = -np.sign(prices).astype(np.int64) * clear  # Prices of upper bounds are negative.
        is_exact, exact, active = exchange_active_set(
            inverse, free, self._banded, lower, upper, guess, MOST_EXCHANGES
        )
        if is_exact:
            return QpResult(exact.clip(-1, 1), QpStatus.SOLVED, details.iter, active)
        if max(details.primal_res, details.dual_res) < ACCEPTED_RESIDUAL:
            return QpResult(z.clip(-1, 1), QpStatus.INACCURATE, details.iter, guess)
        return self._failed(details.iter)

    def _failed(self, iterations: int) -> QpResult:
        z = np.zeros(self.A.shape[1])
        return QpResult(z, QpStatus.FAILED, iterations, self._unbound)


@compiled
def is_within(A: BandedRows, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    """Whether z (nz,) keeps all bounds; not if any of this is no number."""
    for x in z:
        if not abs(x) <= 1 + FEASIBILITY:
            return False
    for i in range(len(lower)):
        x = row_dot(A, i, z)
        if not (lower[i] - FEASIBILITY <= x <= upper[i] + FEASIBILITY):
            return False
    return True


@compiled
def screened(
    lower: np.ndarray, upper: np.ndarray, reach: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(lower, upper), each (rows,), infinite where no value within +- `reach` can be beyond."""
    return np.where(lower <= -reach, -np.inf, lower), np.where(upper >= reach, np.inf, upper)


@compiled
def violations(
    z: np.ndarray, of_rows: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """(nz + rows,), 1 where z or its rows exceed an upper bound, -1 a lower one, else 0."""
    found = np.zeros(len(z) + len(of_rows), dtype=np.int64)
    for i in range(len(z)):
        if abs(z[i]) > 1 + FEASIBILITY:
            found[i] = 1 if z[i] > 0 else -1
    for i in range(len(of_rows)):
        if of_rows[i] > upper[i] + FEASIBILITY:
            found[len(z) + i] = 1
        elif of_rows[i] < lower[i] - FEASIBILITY:
            found[len(z) + i] = -1
    return found
