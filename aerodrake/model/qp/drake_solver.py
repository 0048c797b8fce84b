"""Quadratic programs as a `MathematicalProgram` for a solver of Drake."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from pydrake.solvers import (
    Binding,
    BoundingBoxConstraint,
    LinearConstraint,
    MathematicalProgram,
    MathematicalProgramResult,
    QuadraticCost,
    SolutionResult,
    SolverInterface,
    SolverOptions,
)

from aerodrake.model.qp.quadratic_program import Constraints, QuadraticProgram
from aerodrake.model.qp.refinement import estimated_active_set, exact_minimiser, residual
from aerodrake.model.qp.result import QpResult, QpStatus
from aerodrake.model.qp.solver import QpSolver

ACCEPTED_RESIDUAL = 1e-3
"""Largest residual of an iterate that is used as an inaccurate solution."""

INFEASIBLE = (SolutionResult.kInfeasibleConstraints, SolutionResult.kInfeasibleOrUnbounded)


class BoundProgram(NamedTuple):
    """A `MathematicalProgram` in z (nz,) whose coefficients change from program to program."""

    program: MathematicalProgram
    cost: "Binding[QuadraticCost]"
    box: "Binding[BoundingBoxConstraint]"
    rows: "Binding[LinearConstraint]"

    @classmethod
    def make(cls, nz: int) -> "BoundProgram":
        """Returns a program with one row, which is not bounded."""
        program = MathematicalProgram()
        z = program.NewContinuousVariables(nz, "z")
        return cls(
            program,
            program.AddQuadraticCost(np.eye(nz), np.zeros(nz), z, is_convex=True),
            program.AddBoundingBoxConstraint(-1.0, 1.0, z),
            # Drake adds no constraint without rows.
            program.AddLinearConstraint(np.ones((1, nz)), [-np.inf], [np.inf], z),
        )

    def update(self, program: QuadraticProgram, constraints: Constraints) -> None:
        """Sets cost and rows to those of a program; the cost is divided by its scale."""
        nz, scale = len(program.g), program.scale
        self.cost.evaluator().UpdateCoefficients(program.H / scale, program.g / scale, 0, True)
        N, lower, upper = (part[nz:] for part in constraints)
        self.rows.evaluator().UpdateCoefficients(N, lower, upper)

    def multipliers(self, result: MathematicalProgramResult) -> np.ndarray:
        """Returns the multipliers (nc,) of the constraints, positive for upper bounds."""
        bindings = [self.box, self.rows] if self.rows.evaluator().num_constraints() else [self.box]
        return -np.concatenate([result.GetDualSolution(binding) for binding in bindings])


class DrakeQpSolver(QpSolver):
    """A solver of Drake, whose approximate solution is made exact where possible.

    Programs in equally many variables share one `MathematicalProgram`. From the multipliers
    follows the active set, and from that the exact minimiser, if it satisfies the optimality
    conditions. Otherwise the iterate is used if its residuals are small.

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
        self._programs: dict[int, BoundProgram] = {}

    def _solve(self, program: QuadraticProgram, constraints: Constraints) -> QpResult:
        nz = len(program.g)
        if nz not in self._programs:
            self._programs[nz] = BoundProgram.make(nz)
        bound = self._programs[nz]
        bound.update(program, constraints)
        result = self._solver.Solve(bound.program, None, self._options)
        iterations = iterations_of(result)
        # The status alone does not tell: an infeasible program may have a finite, huge z,
        # `is_success` is also true of inaccurate ones, and an iteration limit may leave a good z.
        if result.get_solution_result() in INFEASIBLE:
            return QpResult.without_solution(nz, QpStatus.INFEASIBLE, iterations)
        z = result.get_x_val()
        multipliers = bound.multipliers(result)
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
