"""Solver of the MPC's programs."""

from typing import Self

from pydrake.solvers import ClarabelSolver

from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.qp.drake_solver import DrakeQpSolver
from aerodrake.model.qp.quadratic_program import is_within
from aerodrake.model.qp.result import QpResult, QpStatus, is_solved
from aerodrake.model.qp.solver import QpSolver
from aerodrake.model.qp.solvers import make_solver
from aerodrake.scenario import Mpc


class MpcSolver:
    """Solves the programs of one formulation.

    With the shortcut, the unconstrained minimiser is computed first, which is the solution if it
    satisfies all bounds. One solver solves all other programs. If it finds no solution, the bounds
    of the vehicle are relaxed as far as full braking requires; if that is not enough, custom
    constraints are softened as far as their least violation requires. A program with a lower
    bound above its upper one is neither relaxed nor softened.

    Softened programs are ill-conditioned, with feasible sets that are hardly more than a point.
    An interior-point method solves them; operator splitting does not converge.

    Args:
        formulation: Forms the programs.
        solver: Solves the programs that the shortcut does not.
        has_shortcut: False if `solver` solves every program.
    """

    def __init__(self, formulation: MpcFormulation, solver: QpSolver, has_shortcut: bool = True):
        self._formulation, self._solver = formulation, solver
        self._has_shortcut = has_shortcut
        self._interior_point = DrakeQpSolver(ClarabelSolver(), {})

    @classmethod
    def make(cls, formulation: MpcFormulation, config: Mpc) -> Self:
        """Returns the solver of a scenario.

        Raises:
            BadInput: if this machine lacks `config.solver`.
        """
        solver = make_solver(config.solver, config.max_iterations)
        return cls(formulation, solver, config.shortcut)

    def solve(self, program: MpcProgram) -> QpResult:
        """Solves one program, as formed by the formulation."""
        z = program.minimiser if self._has_shortcut else None
        if z is not None and is_within(z, program.A, program.lower, program.upper):
            return QpResult(z.clip(-1, 1), QpStatus.UNCONSTRAINED)
        result = self._solver.solve(program)
        if is_solved(result.status) or not (program.lower <= program.upper).all():
            return result
        relaxed = self._solver.solve(self._formulation.relaxed(program))
        if is_solved(relaxed.status):
            return relaxed._replace(status=QpStatus.RELAXED)
        softened = self._softened(program) if self._formulation.custom.constraints else result
        return softened if is_solved(softened.status) else result

    def _softened(self, program: MpcProgram) -> QpResult:
        """Solves a program with the least violation of the custom constraints."""
        least = self._interior_point.solve(self._formulation.least_violation(program))
        if not is_solved(least.status):
            return least
        softened = self._formulation.relaxed(program).admitting(least.z[: len(program.g)])
        result = self._interior_point.solve(softened)
        return result._replace(status=QpStatus.SOFTENED) if is_solved(result.status) else result
