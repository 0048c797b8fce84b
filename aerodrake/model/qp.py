"""A condensed, scaled quadratic program, built once and solved at every tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from pydrake.solvers import MathematicalProgram, OsqpSolver, SolverOptions
from scipy.linalg import cho_factor, cho_solve

from aerodrake.model.active_set import exchange_active_set

FEASIBILITY = 1e-6
"""By how much the unconstrained minimiser may exceed a scaled bound and still be the solution."""

ACCEPTED_RESIDUAL = 1e-3
"""Largest scaled OSQP residual with which an iterate counts as an answer."""


class QpStatus(IntEnum):
    """How the answer came about, best first.

    UNCONSTRAINED and SOLVED are exact: the conditions of optimality were
    checked. INACCURATE is an OSQP iterate with small residuals.
    """

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
    stays, the rest changes from call to call. Four things make it fast and
    exact: the unconstrained minimiser is the solution whenever it satisfies
    every bound; rows that no z in the box can violate are screened out; the
    cost is scaled by its mean diagonal; and OSQP's iterate, which tells what
    bounds are active, is made exact by exchanging them.

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
            factor = cho_factor(H, check_finite=False)
        except np.linalg.LinAlgError:
            return failed
        free = -cho_solve(factor, g, check_finite=False)
        if self._is_feasible(free, lower, upper):
            return QpResult(np.clip(free, -1, 1), QpStatus.UNCONSTRAINED, 0)

        lower = np.where(lower > -self._reach, lower, -np.inf)
        upper = np.where(upper < self._reach, upper, np.inf)
        scale = 1 / np.diag(H).mean()
        self._cost.evaluator().UpdateCoefficients(H * scale, g * scale, 0, True)
        self._rows.evaluator().set_bounds(lower, upper)
        result = self._solver.Solve(self._program, None, self._options)
        details = result.get_solver_details()
        z = result.get_x_val()
        # An infeasible program comes back with a z that is huge, but finite.
        if not (np.isfinite(z).all() and np.abs(z).max() < 2):
            return QpResult(failed.z, QpStatus.FAILED, details.iter)
        live = np.isfinite(lower) | np.isfinite(upper)
        box = np.ones(len(z))
        prices = result.GetDualSolution(self._rows)[live]
        exact = exchange_active_set(
            factor,
            free,
            np.vstack([np.eye(len(z)), self.A[live]]),
            np.concatenate([-box, lower[live]]),
            np.concatenate([box, upper[live]]),
            np.concatenate([result.GetDualSolution(self._box), prices]),
        )
        if exact is not None:
            return QpResult(np.clip(exact, -1, 1), QpStatus.SOLVED, details.iter)
        if max(details.primal_res, details.dual_res) < ACCEPTED_RESIDUAL:
            return QpResult(np.clip(z, -1, 1), QpStatus.INACCURATE, details.iter)
        return QpResult(failed.z, QpStatus.FAILED, details.iter)

    def _is_feasible(self, z: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> bool:
        if np.abs(z).max() > 1 + FEASIBILITY:
            return False
        value = self.A @ z
        return bool((value >= lower - FEASIBILITY).all() and (value <= upper + FEASIBILITY).all())
