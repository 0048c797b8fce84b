"""A condensed, scaled quadratic program, built once and solved at every tick."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolutionResult, SolverOptions
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtri

from aerodrake.model.qp.active_set import exchange_active_set
from aerodrake.model.qp.banded_rows import BandedRows, row_dot, rows_dot
from aerodrake.support.compiled import compiled

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
    OSQP's iterate. INACCURATE is such an iterate with small residuals. RELAXED is exact for
    bounds that were widened, since none could keep them. The others are no answers: no z
    keeps all bounds; iterations ran out; numbers are not finite, or H is not positive
    definite; and nobody asked.
    """

    UNCONSTRAINED = 0
    EXCHANGED = 1
    SOLVED = 2
    INACCURATE = 3
    RELAXED = 4
    INFEASIBLE = 5
    ITERATION_LIMIT = 6
    NON_FINITE = 7
    MISSED = 8


def is_answer(status: float) -> bool:
    """Whether there is a z to go by."""
    return status <= QpStatus.RELAXED


def is_bound(status: float) -> bool:
    """Whether bounds hold the answer, and which they are is known."""
    return QpStatus.UNCONSTRAINED < status <= QpStatus.RELAXED


class QpResult(NamedTuple):
    """The answer to one program.

    Attributes:
        z: (nz,) the minimiser; zeros if there is no answer.
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
        self._max_iterations = max_iterations
        # What is compiled is loaded now, and not at the first tick that a bound holds.
        self.solve(np.eye(nz), -2.0 * np.eye(nz)[0], -unbounded, unbounded)

    def solve(
        self,
        H: np.ndarray,
        g: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        active: np.ndarray | None = None,
        budget: int | None = None,
    ) -> QpResult:
        """Solves one program.

        Args:
            H: (nz, nz), symmetric and positive definite, row by row in memory.
            g: (nz,).
            lower, upper: (rows,).
            active: (nz + rows,), those of a similar program; without, or where none
                were, the bounds that the unconstrained minimiser violates.
            budget: If given, there is time for so many iterations of OSQP, and nothing else.
        """
        # Symmetric: the transpose, as LAPACK wants it, is the same without a copy.
        factor, is_indefinite = dpotrf(H.T, lower=1, clean=0)
        if is_indefinite or not np.isfinite(factor.diagonal()).all():
            return self._without_answer(QpStatus.NON_FINITE, 0)
        free, _ = dpotrs(factor, -g, lower=1)
        if budget is None and (result := self.accepted(free, lower, upper)) is not None:
            return result
        if not np.isfinite(free).all() or np.isnan(lower).any() or np.isnan(upper).any():
            return self._without_answer(QpStatus.NON_FINITE, 0)
        if (lower > upper).any():
            return self._without_answer(QpStatus.INFEASIBLE, 0)
        lower, upper = screened(lower, upper, self._reach)
        inverse = np.triu(dtrtri(factor, lower=1)[0].T)
        if budget is not None:
            return self._by_osqp(H, g, lower, upper, inverse, free, budget, 0)
        if active is None or not active.any():
            active = violations(free, rows_dot(self._banded, free), lower, upper)
        is_exact, z, held = exchange_active_set(
            inverse, free, self._banded, lower, upper, active, MOST_EXCHANGES
        )
        if is_exact:
            return QpResult(z.clip(-1, 1), QpStatus.EXCHANGED, 0, held)
        return self._by_osqp(
            H, g, lower, upper, inverse, free, self._max_iterations, MOST_EXCHANGES
        )

    def accepted(self, free: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> QpResult | None:
        """The unconstrained minimiser as the answer; None if it does not keep all bounds.

        Args:
            free: (nz,), the minimiser.
            lower, upper: (rows,).
        """
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
        max_iterations: int,
        exchanges: int,
    ) -> QpResult:
        scale = 1 / np.diag(H).mean()
        self._cost.evaluator().UpdateCoefficients(H * scale, g * scale, 0, True)
        self._rows.evaluator().set_bounds(lower, upper)
        result = self._solver.Solve(self._program, None, self._options(max_iterations))
        details, verdict = result.get_solver_details(), result.get_solution_result()
        z = result.get_x_val()
        if verdict is SolutionResult.kInfeasibleConstraints:
            return self._without_answer(QpStatus.INFEASIBLE, details.iter)
        if not np.abs(z).max() < 2:  # Of an infeasible program it is huge, but finite.
            return self._without_answer(QpStatus.ITERATION_LIMIT, details.iter)
        prices = np.concatenate(
            [result.GetDualSolution(self._box), result.GetDualSolution(self._rows)]
        )
        clear = np.abs(prices) > 1e-3 * np.abs(prices).max(initial=0.0)
        guess = -np.sign(prices).astype(np.int64) * clear  # Prices of upper bounds are negative.
        is_exact, exact, active = exchange_active_set(
            inverse, free, self._banded, lower, upper, guess, exchanges
        )
        if is_exact:
            return QpResult(exact.clip(-1, 1), QpStatus.SOLVED, details.iter, active)
        if max(details.primal_res, details.dual_res) < ACCEPTED_RESIDUAL:
            return QpResult(z.clip(-1, 1), QpStatus.INACCURATE, details.iter, guess)
        return self._without_answer(QpStatus.ITERATION_LIMIT, details.iter)

    def _options(self, max_iterations: int) -> SolverOptions:
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
        return options

    def _without_answer(self, status: QpStatus, iterations: int) -> QpResult:
        return QpResult(np.zeros(self.A.shape[1]), status, iterations, self._unbound)


@compiled
def is_within(A: BandedRows, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
    """Whether z (nz,) keeps its box, and A z `lower` and `upper` (rows,); not if one is nan."""
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
    """(lower, upper), infinite where no value within +- `reach` is beyond; all four (rows,)."""
    return np.where(lower <= -reach, -np.inf, lower), np.where(upper >= reach, np.inf, upper)


@compiled
def violations(
    z: np.ndarray, of_rows: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """(nz + rows,), 1 where z or its rows exceed an upper bound, -1 a lower one, else 0.

    Args:
        z: (nz,), in a box of +-1.
        of_rows: (rows,), A z.
        lower, upper: (rows,), its bounds.
    """
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
