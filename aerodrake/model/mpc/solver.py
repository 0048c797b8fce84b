"""Solver of the MPC's programs."""

from dataclasses import replace
from typing import Self

from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.qp.quadratic_program import is_within
from aerodrake.model.qp.result import QpResult, QpStatus, is_solved
from aerodrake.model.qp.solver import QpSolver
from aerodrake.model.qp.solvers import make_solver
from aerodrake.scenario import Mpc


class MpcSolver:
    """Solves the programs of one formulation.

    With the shortcut, the unconstrained minimiser is computed first, which is the solution if it
    satisfies all bounds. All other programs are solved by one solver. Infeasible bounds are
    relaxed as far as full braking requires, unless a lower bound exceeds its upper one, which is
    an error.

    Args:
        formulation: Forms the programs.
        solver: Solves them.
        has_shortcut: False if `solver` solves every program.
    """

    def __init__(self, formulation: MpcFormulation, solver: QpSolver, has_shortcut: bool = True):
        self._formulation, self._solver = formulation, solver
        self._has_shortcut = has_shortcut

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
        qp = program.qp
        if self._has_shortcut and is_within(qp.minimiser, qp.A, qp.lower, qp.upper):
            return QpResult(qp.minimiser.clip(-1, 1), QpStatus.UNCONSTRAINED)
        result = self._solver.solve(qp)
        if is_solved(result.status) or not (qp.lower <= qp.upper).all():
            return result
        relaxed = self._formulation.relaxed(program)
        again = self._solver.solve(replace(qp, lower=relaxed.lower, upper=relaxed.upper))
        return again._replace(status=QpStatus.RELAXED) if is_solved(again.status) else result
