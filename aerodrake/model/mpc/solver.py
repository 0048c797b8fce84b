"""Solver of the MPC's programs."""

from typing import Self

from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
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
        self._interior_point = make_solver("clarabel", formulation.config.max_iterations)

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
        if z is not None and program.is_feasible(z):
            return QpResult(z.clip(-1, 1), QpStatus.UNCONSTRAINED)
        result = self._solver.solve(program)
        if is_solved(result.status) or not (program.lower <= program.upper).all():
            return result
        relaxed = self._formulation.relaxed(program)
        again, status = self._solver.solve(relaxed), QpStatus.RELAXED
        if not is_solved(again.status) and self._formulation.custom.constraints:
            again, status = self._solve_softened(relaxed), QpStatus.SOFTENED
        return again._replace(status=status) if is_solved(again.status) else result

    def _solve_softened(self, relaxed: MpcProgram) -> QpResult:
        """Solves a relaxed program with the least violation of the custom constraints."""
        least = self._interior_point.solve(self._formulation.least_violation(relaxed))
        if not is_solved(least.status):
            return least
        return self._interior_point.solve(relaxed.admitting(least.z[: len(relaxed.g)]))
