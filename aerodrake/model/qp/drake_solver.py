"""Quadratic programs as a `MathematicalProgram` for a solver of Drake."""

from collections.abc import Mapping
from typing import NamedTuple, Self

import numpy as np
from pydrake.solvers import (
    Binding,
    LinearConstraint,
    MathematicalProgram,
    MathematicalProgramResult,
    QuadraticCost,
    SolutionResult,
    SolverInterface,
    SolverOptions,
)
from scipy.linalg.lapack import dtrtrs

from aerodrake.model.qp.quadratic_program import Constraints, QuadraticProgram
from aerodrake.model.qp.refinement import estimated_active_set, exact_minimiser, residual
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.qp.solver import QpSolver

ACCEPTED_RESIDUAL = 1e-3
"""Largest residual of an iterate that is used as an inaccurate solution."""

INFEASIBLE = (SolutionResult.kInfeasibleConstraints, SolutionResult.kInfeasibleOrUnbounded)


class ScaledProgram(NamedTuple):
    """A `MathematicalProgram` in z (nz,) whose coefficients change from program to program."""

    program: MathematicalProgram
    cost: "Binding[QuadraticCost]"
    rows: "Binding[LinearConstraint]"

    @classmethod
    def make(cls, nz: int) -> Self:
        """Returns a program of nz variables with placeholder coefficients."""
        program, one = MathematicalProgram(), np.ones(nz)
        z = program.NewContinuousVariables(nz, "z")
        return cls(
            program,
            program.AddQuadraticCost(np.eye(nz), 0 * one, z, is_convex=True),
            program.AddLinearConstraint(np.eye(nz), -one, one, z),
        )

    def update(self, program: QuadraticProgram, constraints: Constraints) -> np.ndarray:
        """Sets the coefficients to those of a program, with the cost divided by its scale.

        The rows are scaled so that N H^-1 N^T, the Hessian of the dual, has a unit diagonal: on
        its condition number depends how fast operator splitting converges (Giselsson and Boyd
        2017, doi 10.1109/TAC.2016.2564160).

        Returns:
            (nc,), factors of the rows.
        """
        scale = program.scale
        self.cost.evaluator().UpdateCoefficients(program.H / scale, program.g / scale, 0, True)
        L_inv_N, _ = dtrtrs(program.factor, constraints.N.T, lower=1)
        norms = np.sqrt(scale * (L_inv_N**2).sum(axis=0))
        factors = 1 / np.where(norms > 0, norms, 1.0)
        N, lower, upper = factors[:, None] * constraints.N, constraints.lower, constraints.upper
        self.rows.evaluator().UpdateCoefficients(N, factors * lower, factors * upper)
        return factors


class DrakeQpSolver(QpSolver):
    """A solver of Drake, whose approximate solution is made exact where possible.

    Programs with equally many variables share one `MathematicalProgram`. The solver's multipliers
    give an estimate of the active set, from which `exact_minimiser` starts. If it finds none, the
    iterate is used if its residual is small.

    Args:
        solver: The solver.
        options: Options of the solver by name.
        is_refined: False to use the iterate as it is.
    """

    def __init__(
        self, solver: SolverInterface, options: Mapping[str, float], is_refined: bool = True
    ):
        self._solver, self._is_refined = solver, is_refined
        self._options = SolverOptions()
        for name, value in options.items():
            self._options.SetOption(solver.id(), name, value)
        self._programs: dict[int, ScaledProgram] = {}

    def _solve(self, program: QuadraticProgram, constraints: Constraints) -> QpResult:
        nz = len(program.g)
        if nz not in self._programs:
            self._programs[nz] = ScaledProgram.make(nz)
        scaled = self._programs[nz]
        factors = scaled.update(program, constraints)
        result = self._solver.Solve(scaled.program, None, self._options)
        iterations = iterations_of(result)
        # Of the solver's status only infeasibility is used: `is_success` may be True for an
        # inaccurate z, and False for a good one at the iteration limit.
        if result.get_solution_result() in INFEASIBLE:
            return QpResult.without_solution(nz, QpStatus.INFEASIBLE, iterations)
        z = result.get_x_val()
        # Drake's multipliers of upper bounds are negative.
        multipliers = -factors * result.GetDualSolution(scaled.rows)
        if self._is_refined:
            active = estimated_active_set(constraints, z, multipliers)
            exact = exact_minimiser(program, constraints, active)
            if exact is not None:
                return QpResult(exact, QpStatus.SOLVED, iterations)
        if residual(program, constraints, z, multipliers) < ACCEPTED_RESIDUAL:
            return QpResult(z.clip(-1, 1), QpStatus.INACCURATE, iterations)
        return QpResult.without_solution(nz, QpStatus.ITERATION_LIMIT, iterations)


def iterations_of(result: MathematicalProgramResult) -> int:
    """Returns the iterations of a solver; 0 if Drake does not report them."""
    details = result.get_solver_details()
    return int(getattr(details, "iter", getattr(details, "iterations", 0)))
