"""Faults of the reference as a system."""

from collections.abc import Sequence

import numpy as np
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.reference.fault import with_faults
from aerodrake.scenario import AnyFault
from aerodrake.support.arguments import Duration, Vector, checked


class ReferenceFaultSystem(LeafSystem):
    """Adds faults to a reference.

    Ports:
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' in m and m/s, now and at each stage.
        out `horizon` (6 (N + 1)): p_Ed, p_Ed' with the faults that are active now.
    State, rate:
        none; feeds through, and is a function of time.

    Args:
        faults: Any faults; only those of the reference are applied.
        settle_s: s, hover before reference time 0.
        stages_s: (N + 1,) s, from now to each stage, 0 first.
    """

    @checked
    def __init__(self, faults: Sequence[AnyFault], settle_s: Duration, stages_s: Vector):
        super().__init__()
        self._faults, self._settle_s, self._stages = faults, settle_s, stages_s
        size = 6 * len(stages_s)
        self._requested = self.DeclareVectorInputPort("horizon", size)
        self.DeclareVectorOutputPort(
            "horizon", size, self._calc_horizon, {self._requested.ticket(), self.time_ticket()}
        )

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        rows = self._requested.Eval(context).reshape(-1, 6)
        now = round(context.get_time() - self._settle_s, 9)
        motion = with_faults(self._faults, now, now + self._stages, (rows[:, :3], rows[:, 3:]))
        output.SetFromVector(np.hstack(motion).ravel())
