"""What is the matter with the MPC's ticks, and when."""

from __future__ import annotations

from collections.abc import Sequence

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.mpc.fault import MpcFault
from aerodrake.scenario import (
    MPC_FAULTS,
    AnyFault,
    MpcInfeasible,
    MpcMissed,
    MpcNonFinite,
    MpcStarved,
)

CODES = {
    MpcStarved: MpcFault.STARVED,
    MpcInfeasible: MpcFault.INFEASIBLE,
    MpcNonFinite: MpcFault.NON_FINITE,
    MpcMissed: MpcFault.MISSED,
}
"""By the kinds of faults that are the MPC's."""


class MpcFaultSystem(LeafSystem):
    """Tells the MPC what its ticks suffer from.

    Ports:
        out `fault` (2): an `MpcFault`, the worst of those that are active, and the
            iterations of OSQP that are left where it is STARVED.
    State, rate:
        none; a function of time.

    Args:
        faults: Of which those of the MPC count.
        settle_s: s, hover before reference time 0.
    """

    def __init__(self, faults: Sequence[AnyFault], settle_s: float):
        super().__init__()
        self._faults = [fault for fault in faults if isinstance(fault, MPC_FAULTS)]
        self._settle_s = settle_s
        self.DeclareVectorOutputPort("fault", 2, self._calc_fault, {self.time_ticket()})

    def _calc_fault(self, context: Context, output: BasicVector) -> None:
        now = round(context.get_time() - self._settle_s, 9)
        active = [fault for fault in self._faults if fault.is_active(now)]
        worst = max((CODES[type(fault)] for fault in active), default=MpcFault.NONE)
        starved = [fault.iterations for fault in active if isinstance(fault, MpcStarved)]
        output.SetFromVector([worst, min(starved, default=0)])
