"""A condensed, scaled quadratic program, set up once and solved at every tick."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolutionResult
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtri

from aerodrake.model.qp.active_set import FactorisedQp, solve_active_set
from aerodrake.model.qp.banded_rows import BandedRows, rows_dot
from aerodrake.model.qp.bounds import is_within, violated, without_redundant

MAX_EXCHANGES = 100
"""Largest number of constraints that the active-set method adds."""

ACCEPTED_RESIDUAL = 1e-3
"""Largest scaled OSQP residual of an iterate that is used as an inaccurate solution."""

DIVERGED = 2.0
"""|z| beyond which an OSQP iterate is discarded; that of an infeasible program is huge."""

OSQP_OPTIONS = {
    "scaling": 0,
    "rho": 0.03,
    "adaptive_rho_interval": 25,
    "check_termination": 25,
    "eps_abs": 1e-5,
    "eps_rel": 1e-5,
    "polishing": 0,
}


class QpStatus(IntEnum):
    """Outcome of solving a program, best first; from INFEASIBLE on there is no solution.

    UNCONSTRAINED: exact, the unconstrained minimiser.
    EXCHANGED: exact, by the active-set method from the last active set or from the
        constraints that the unconstrained minimiser violates.
    SOLVED: exact, by the active-set method from OSQP's iterate.
    INACCURATE: OSQP's iterate, with small residuals.
    RELAXED: exact for widened bounds; with the given ones the program is infeasible.
    INFEASIBLE: no z satisfies all bounds.
    ITERATION_LIMIT: OSQP reached its iteration limit.
    NON_FINITE: an input is NaN or infinite, or H is not positive definite.
    """

    UNCONSTRAINED = 0
    EXCHANGED = 1
    SOLVED = 2
    INACCURATE = 3
    RELAXED = 4
    INFEASIBLE = 5
    ITERATION_LIMIT = 6
    NON_FINITE = 7


def is_solved(status: float) -> bool:
    """Returns True if a program with this status has a solution."""
    return status <= QpStatus.RELAXED


def is_constrained(status: float) -> bool:
    """Returns True if a program with this status has a solution with a known active set."""
    return QpStatus.UNCONSTRAINED < status <= QpStatus.RELAXED


class QpResult(NamedTuple):
    """Solution of one program.

    Attributes:
        z: (nz,), the minimiser; zeros without a solution.
        status: A `QpStatus`.
        iterations: Iterations of OSQP; 0 if it was not called.
        active: (nz + rows,), active set, bounds of z first: 1 for an upper bound, -1 for a
            lower one, 0 for an inactive constraint.
    """

    z: np.ndarray
    status: int
    iterations: int
    active: np.ndarray


class CondensedQp:
    """min z^T H z / 2 + g^T z  subject to  |z| <= 1,  lower <= A z <= upper.

    The caller scales z by the input bounds and the rows of A to unit norm. A is constant. A
    program is solved in these steps:

    1. The unconstrained minimiser is the solution if it satisfies all bounds.
    2. Redundant constraints, which no z in the box violates, are removed.
    3. `solve_active_set` starts from the active set of a similar program, which usually
       differs by few constraints, or else from the bounds that the minimiser of step 1 violates.
    4. If that fails, it starts from the active set of OSQP's iterate. OSQP receives the cost
       divided by the mean diagonal element of H.
    5. If that fails as well, the iterate is used if its residuals are small.

    Args:
        A: (rows, nz), rows of unit norm.
        max_iterations: Iteration limit of OSQP. A time limit would make flights
            unrepeatable.
    """

    def __init__(self, A: np.ndarray, max_iterations: int):
        rows, nz = A.shape
        self.A = A
        self._banded = BandedRows.of(A)
        self._no_active = np.zeros(nz + rows, dtype=np.int64)
        self._reach = np.abs(A).sum(axis=1)
        self._program = MathematicalProgram()
        z = self._program.NewContinuousVariables(nz, "z")
        self._cost = self._program.AddQuadraticCost(np.eye(nz), np.zeros(nz), z, is_convex=True)
        self._box = self._program.AddBoundingBoxConstraint(-1.0, 1.0, z)
        unbounded = np.full(rows, np.inf)
        self._rows = self._program.AddLinearConstraint(A, -unbounded, unbounded, z)
        self._solver = OsqpSolver()
        for name, value in OSQP_OPTIONS.items():
            self._program.SetSolverOption(self._solver.id(), name, value)
        self._max_iterations = max_iterations
        # A constrained program, so that compiled code is loaded before the first tick.
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
            H: (nz, nz), symmetric and positive definite, C-contiguous.
            g: (nz,).
            lower, upper: (rows,).
            active: (nz + rows,), active set of a similar program. If it is None or empty, the
                bounds that the unconstrained minimiser violates are used.
        """
        factor, minimiser = _factorise(H, g)
        if (result := self.accept_unconstrained(minimiser, lower, upper)) is not None:
            return result
        if (status := _invalid(minimiser, lower, upper)) is not None:
            return self._unsolved(status)
        lower, upper = without_redundant(lower, upper, self._reach)
        V = np.triu(dtrtri(factor, lower=1)[0].T)
        qp = FactorisedQp(V, minimiser, self._banded, lower, upper)
        if active is None or not active.any():
            active = violated(minimiser, rows_dot(self._banded, minimiser), lower, upper)
        exact = solve_active_set(qp, active, MAX_EXCHANGES)
        if exact.is_optimal:
            return QpResult(exact.z.clip(-1, 1), QpStatus.EXCHANGED, 0, exact.active)
        result, guess = self._osqp(H, g, lower, upper, self._max_iterations)
        if guess is not None:
            exact = solve_active_set(qp, guess, MAX_EXCHANGES)
            if exact.is_optimal:
                z = exact.z.clip(-1, 1)
                return QpResult(z, QpStatus.SOLVED, result.iterations, exact.active)
        return result

    def solve_by_osqp(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray, iterations: int
    ) -> QpResult:
        """Solves one program by OSQP alone, to its tolerances or for so many `iterations`.

        H, g, lower and upper are as for `solve`.
        """
        _, minimiser = _factorise(H, g)
        if (status := _invalid(minimiser, lower, upper)) is not None:
            return self._unsolved(status)
        lower, upper = without_redundant(lower, upper, self._reach)
        return self._osqp(H, g, lower, upper, iterations)[0]

    def accept_unconstrained(
        self, z: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> QpResult | None:
        """Returns the unconstrained minimiser as the solution; None if it violates a bound.

        Args:
            z: (nz,), the minimiser.
            lower, upper: (rows,).
        """
        if not is_within(self._banded, z, lower, upper):
            return None
        return QpResult(z.clip(-1, 1), QpStatus.UNCONSTRAINED, 0, self._no_active)

    def _osqp(
        self, H: np.ndarray, g: np.ndarray, lower: np.ndarray, upper: np.ndarray, iterations: int
    ) -> tuple[QpResult, np.ndarray | None]:
        """Runs OSQP for up to so many iterations.

        Returns:
            OSQP's iterate, INACCURATE if its residuals are small, and its active set
            (nz + rows,); None if the program is infeasible or OSQP diverged.
        """
        scale = 1 / np.diag(H).mean()
        self._cost.evaluator().UpdateCoefficients(H * scale, g * scale, 0, True)
        self._rows.evaluator().set_bounds(lower, upper)
        self._program.SetSolverOption(self._solver.id(), "max_iter", iterations)
        result = self._solver.Solve(self._program)
        details, z = result.get_solver_details(), result.get_x_val()
        if result.get_solution_result() is SolutionResult.kInfeasibleConstraints:
            return self._unsolved(QpStatus.INFEASIBLE, details.iter), None
        unsolved = self._unsolved(QpStatus.ITERATION_LIMIT, details.iter)
        if not np.abs(z).max() < DIVERGED:
            return unsolved, None
        multipliers = np.concatenate([result.GetDualSolution(b) for b in (self._box, self._rows)])
        magnitude = np.abs(multipliers)
        is_active = magnitude > 1e-3 * magnitude.max(initial=0.0)
        # Drake's multipliers of upper bounds are negative.
        guess = -np.sign(multipliers).astype(np.int64) * is_active
        if max(details.primal_res, details.dual_res) < ACCEPTED_RESIDUAL:
            return QpResult(z.clip(-1, 1), QpStatus.INACCURATE, details.iter, guess), guess
        return unsolved, guess

    def _unsolved(self, status: QpStatus, iterations: int = 0) -> QpResult:
        return QpResult(np.zeros(self.A.shape[1]), status, iterations, self._no_active)


def _factorise(H: np.ndarray, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns the lower Cholesky factor of H, and the unconstrained minimiser (nz,).

    The minimiser is NaN if H is not positive definite and finite.
    """
    # H is symmetric: its transpose has LAPACK's order without a copy.
    factor, is_indefinite = dpotrf(H.T, lower=1, clean=0)
    if is_indefinite or not np.isfinite(factor.diagonal()).all():
        return factor, np.full_like(g, np.nan)
    return factor, dpotrs(factor, -g, lower=1)[0]


def _invalid(minimiser: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> QpStatus | None:
    """Returns why a program is not to be solved: NON_FINITE, INFEASIBLE, or None."""
    if not np.isfinite(minimiser).all() or np.isnan(lower).any() or np.isnan(upper).any():
        return QpStatus.NON_FINITE
    return QpStatus.INFEASIBLE if (lower > upper).any() else None
