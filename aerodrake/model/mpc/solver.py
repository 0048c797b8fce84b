"""The MPC's programs, solved."""

from __future__ import annotations

import numpy as np

from aerodrake.model.mpc.formulation import MpcFormulation, MpcProgram
from aerodrake.model.mpc.redundancy import Redundancy
from aerodrake.model.qp.condensed_qp import CondensedQp, QpResult, QpStatus, is_answer


class MpcSolver:
    """Solves the programs of one formulation, the easy ones without forming their H.

    Where no z keeps all bounds, they are relaxed as far as physics asks for. Bounds that
    contradict each other are not: there something is wrong.

    Args:
        formulation: Whose programs they are.
    """

    def __init__(self, formulation: MpcFormulation):
        self._formulation = formulation
        self._qp = CondensedQp(formulation.A, formulation.config.max_iterations)
        self._redundancy = Redundancy(formulation.condensing, formulation.W_2)

    def solve(
        self, program: MpcProgram, active: np.ndarray | None = None, budget: int | None = None
    ) -> QpResult:
        """Solves one program.

        Args:
            program: Of the formulation.
            active: (nz + rows,), the bounds that held the program of the tick before, as
                `QpResult` has them; None where none did.
            budget: If given, there is time for so many iterations of OSQP, and nothing else.
        """
        g, lower, upper = program.g, program.lower, program.upper
        # Where bounds held the last program, some most likely hold this one.
        if active is None and budget is None:
            z = self._redundancy.minimiser(program.C, g, program.task_jacobian)
            if z is not None and (result := self._qp.accepted(z, lower, upper)) is not None:
                return result
        result = self._qp.solve(program.H, g, lower, upper, active, budget)
        if is_answer(result.status) or budget is not None or not (lower <= upper).all():
            return result
        relaxed = self._formulation.relaxed(program)
        again = self._qp.solve(program.H, g, relaxed.lower, relaxed.upper)
        return again._replace(status=QpStatus.RELAXED) if is_answer(again.status) else result
