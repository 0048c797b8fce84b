"""What can be done to a tick of the MPC so that it has no answer."""

from __future__ import annotations

from dataclasses import replace
from enum import IntEnum

import numpy as np

from aerodrake.model.mpc.formulation import MpcProgram


class MpcFault(IntEnum):
    """What is wrong with a tick, worst last."""

    NONE = 0
    STARVED = 1
    INFEASIBLE = 2
    NON_FINITE = 3
    MISSED = 4


def spoiled(program: MpcProgram, fault: float) -> MpcProgram:
    """The program with a fault in it, where the fault is one of programs."""
    if fault == MpcFault.INFEASIBLE:
        return replace(
            program, lower=np.ones_like(program.lower), upper=-np.ones_like(program.upper)
        )
    if fault == MpcFault.NON_FINITE:
        return replace(program, g=np.full_like(program.g, np.nan))
    return program
