"""Solver of the MPC's programs."""

import numpy as np

from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.qp.condensed_qp import CondensedQp, QpResult, QpStatus, is_solved


class MpcSolver:
    """Solves the programs of one formulation.

    Infeasible bounds are relaxed as
    far as full braking requires, unless a lower bound exceeds its upper one, which is an error.

    Args:
        formulation: Forms the programs.
    """

    def __init__(self, formulation: MpcFormulation):
        self._formulation = formulation
        self._qp = CondensedQp(formulation.A, formulation.config.max_iterations)

    def solve(self, program: MpcProgram, active: np.ndarray | None = None) -> QpResult:
        """Solves one program.

        Args:
            program: As formed by the formulation.
            active: (nz + rows,), active set of the last program, as in `QpResult`; None if it
                had none.
        """
        g, lower, upper = program.g, program.lower, program.upper
        result = self._qp.solve(program.H, g, lower, upper, active)
        if is_solved(result.status) or not (lower <= upper).all():
            return result
        relaxed = self._formulation.relaxed(program)
        again = self._qp.solve(program.H, g, relaxed.lower, relaxed.upper)
        return again._replace(status=QpStatus.RELAXED) if is_solved(again.status) else result
