"""A fault of the samples as a system."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.sample_fault import faulty
from aerodrake.scenario import SampleFault

SAMPLE, STAMPS = 0, 1
"""Groups of the state."""


class SampleFaultSystem(LeafSystem):
    """Samples as they are, but for the time of a fault.

    Ports:
        in `sample` (13 + 2 n): the last sample.
        in `stamps` (3): s, when its groups were taken.
        out `sample` (13 + 2 n), `stamps` (3): as they arrive. They feed through.
    State:
        sample and stamps, the last before the fault.
    Rate:
        `period`, by a discrete update.

    Args:
        fault: Which, and when.
        settle_s: Reference time 0.
        period: s, of samples.
        initial: (13 + 2 n,) the sample at time 0.
    """

    def __init__(self, fault: SampleFault, settle_s: float, period: float, initial: np.ndarray):
        super().__init__()
        self._fault = fault
        self._settle_s = settle_s
        self._sample = self.DeclareVectorInputPort("sample", len(initial))
        self._stamps = self.DeclareVectorInputPort("stamps", 3)
        self.DeclareDiscreteState(initial)
        self.DeclareDiscreteState(np.zeros(3))
        self.DeclareVectorOutputPort("sample", len(initial), self._calc_sample)
        self.DeclareVectorOutputPort("stamps", 3, self._calc_stamps)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._hold)

    def _is_active(self, context: Context) -> bool:
        # Rounded, lest a fault begin or end a sample late.
        time = round(context.get_time() - self._settle_s, 9)
        return bool(self._fault.is_active(time))

    def _arriving(self, context: Context) -> tuple[np.ndarray, np.ndarray]:
        sample, stamps = self._sample.Eval(context), self._stamps.Eval(context)
        if not self._is_active(context):
            return sample, stamps
        held = context.get_discrete_state()
        return faulty(self._fault, sample, stamps, held.value(SAMPLE), held.value(STAMPS))

    def _calc_sample(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._arriving(context)[0])

    def _calc_stamps(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._arriving(context)[1])

    def _hold(self, context: Context, discrete: DiscreteValues) -> None:
        if not self._is_active(context):
            discrete.set_value(SAMPLE, self._sample.Eval(context))
            discrete.set_value(STAMPS, self._stamps.Eval(context))
