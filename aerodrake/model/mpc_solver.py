"""The MPC's programs, solved."""

from __future__ import annotations

import numpy as np

from aerodrake.model.mpc import MpcFormulation, MpcProgram
from aerodrake.model.qp import CondensedQp, QpResult
from aerodrake.model.redundancy import Redundancy


class MpcSolver:
    """Solves the programs of one formulation, the easy ones without forming their H.

    Args:
        formulation: Whose programs they are.
    """

    def __init__(self, formulation: MpcFormulation):
        self._qp = CondensedQp(formulation.A, formulation.config.max_iterations)
        self._redundancy = Redundancy(formulation.condensing, formulation.W_2)

    def solve(self, program: MpcProgram, active: np.ndarray | None = None) -> QpResult:
        """Solves one program.

        Args:
            program: Of the formulation.
            active: The bounds that held the program of the tick before, as `QpResult` has
                them; None where none did.
        """
        g, lower, upper = program.g, program.lower, program.upper
        if active is None:  # Where bounds held the last program, some most likely hold this one.
            z = self._redundancy.minimiser(program.C, g, program.carried)
            if z is not None and (result := self._qp.accepted(z, lower, upper)) is not None:
                return result
        return self._qp.solve(program.H, g, lower, upper, active)
