"""A condensed, scaled quadratic program, built once and solved at every tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolverOptions
from scipy.linalg import cho_factor, cho_solve

FEASIBILITY = 1e-6
"""By how much the unconstrained minimiser may exceed a scaled bound and still be the solution."""

ACCEPTED_RESIDUAL = 1e-3
"""Largest scaled OSQP residual with which an iterate counts as an answer."""

OSQP_SOLVED = 1


class QpStatus(IntEnum):
    """How the answer came about, best first."""

    UNCONSTRAINED = 0
    SOLVED = 1
    INACCURATE = 2
    FAILED = 3


@dataclass(frozen=True)
class QpResult:
    """The answer to one program.

    Attributes:
        z: (nz,) the minimiser; zeros if it failed.
        status: How it came about.
        iterations: Of OSQP; 0 where it was not needed.
    """

    z: np.ndarray
    status: QpStatus
    iterations: int


class CondensedQp:
    """min z' H z / 2 + g' z  subject to  |z| <= 1,  lower <= A z <= upper.

    Scaled by the caller: z by the input bounds, the rows of A to unit norm. A
    stays, the rest changes from call to call. Three things make it fast and
    exact: the unconstrained minimiser is the solution whenever it satisfies
    every bound; rows that no z in the box can violate are screened out; and
    the cost is scaled by its mean diagonal.

    Args:
        A: (rows, nz), rows of unit norm.
        max_iterations: Of OSQP. A limit in iterations keeps flights
            repeatable, where one in seconds would not.
    """

    def __init__(self, A: np.ndarray, max_iterations: int):
        rows, nz = A.shape
        self.A = A
        self._reach = np.abs(A).sum(axis=1)
        self._program = MathematicalProgram()
        z = self._program.NewContinuousVariables(nz, "z")
        self._cost = self._program.AddQuadraticCost(np.eye(nz), np.zeros(nz), z, is_convex=True)
        self._program.AddBoundingBoxConstraint(-1.0, 1.0, z)
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
            "polishing": 1,
            "max_iter": max_iterations,
        }.items():
            options.SetOption(self._solver.id(), name, value)
        self._options = options

    def solve(
        self,
        H: np.ndarray,
        g: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
    ) -> QpResult:
        """Solves one program.

        Args:
            H: (nz, nz), symmetric and positive definite.
            g: (nz,).
            lower, upper: (rows,).
        """
        failed = QpResult(np.zeros_like(g), QpStatus.FAILED, 0)
        if not (np.isfinite(g).all() and np.isfinite(H).all()):
            return failed
        if np.isnan(lower).any() or np.isnan(upper).any():
            return failed
        try:
            free = -cho_solve(cho_factor(H, check_finite=False), g, check_finite=False)
        except np.linalg.LinAlgError:
            return failed
        if self._is_feasible(free, lower, upper):
            return QpResult(np.clip(free, -1, 1), QpStatus.UNCONSTRAINED, 0)

        live_lower = np.where(lower > -self._reach, lower, -np.inf)
        live_upper = np.where(upper < self._reach, upper, np.inf)
        scale = 1 / np.diag(H).mean()
        self._cost.evaluator().UpdateCoefficients(H * scale, g * scale, 0, True)
        self._rows.evaluator().set_bounds(live_lower, live_upper)
        result = self._solver.Solve(self._program, None, self._options)
        details = result.get_solver_details()
        z = result.get_x_val()
        # An infeasible program comes back with a huge but finite z: trust the
        # residuals of the iterate, not its finiteness.
        residual = max(details.primal_res, details.dual_res)
        if details.status_val == OSQP_SOLVED:
            status = QpStatus.SOLVED
        elif np.isfinite(z).all() and np.abs(z).max() < 2 and residual < ACCEPTED_RESIDUAL:
            status = QpStatus.INACCURATE
        else:
            return QpResult(failed.z, QpStatus.FAILED, details.iter)
        return QpResult(np.clip(z, -1, 1), status, details.iter)

    def _is_feasible(self, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
        if np.abs(z).max() > 1 + FEASIBILITY:
            return False
        value = self.A @ z
        return bool((value >= lower - FEASIBILITY).all() and (value <= upper + FEASIBILITY).all())
