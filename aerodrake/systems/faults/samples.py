"""Faults of the samples as a system between sensors and state filter."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.sample import Sample
from aerodrake.model.sensing.sample_fault import faulty
from aerodrake.scenario import SampleFault
from aerodrake.support.arguments import Count, Duration, Period, checked
from aerodrake.systems.named_state import NamedState


class SampleFaultSystem(LeafSystem):
    """Passes samples, and changes them during a fault.

    For a fault from the start, the last sample before the fault is the first one.

    Ports:
        in `sample` (13 + 2 n): the last sample, a `VehicleState`.
        in `stamps` (3): s, when its groups were sampled.
        out `sample` (13 + 2 n): the sample that arrives; it feeds through.
        out `stamps` (3): s, the time stamps that arrive; they feed through.
    State:
        `state` (13 + 2 n) and `stamps` (3) of the last sample before the fault; NaN without one.
    Rate:
        `period`, by a discrete update.

    Args:
        fault: Kind, start and duration.
        settle_s: s, hover before reference time 0.
        period: s, of samples.
        size: 13 + 2 n.
    """

    @checked
    def __init__(self, fault: SampleFault, settle_s: Duration, period: Period, size: Count):
        super().__init__()
        self._fault, self._settle_s = fault, settle_s
        self._sample = self.DeclareVectorInputPort("sample", size)
        self._stamps = self.DeclareVectorInputPort("stamps", 3)
        self._last = NamedState(self, Sample(np.full(size, np.nan), np.full(3, np.nan)))
        self.DeclareVectorOutputPort("sample", size, self._calc_sample)
        self.DeclareVectorOutputPort("stamps", 3, self._calc_stamps)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _is_active(self, context: Context) -> bool:
        # Rounding keeps a fault from beginning or ending a sample late.
        return bool(self._fault.is_active(round(context.get_time() - self._settle_s, 9)))

    @staticmethod
    def _has_last(last: Sample) -> bool:
        return bool(np.isfinite(last.stamps).all())

    def _measured(self, context: Context) -> Sample:
        return Sample(self._sample.Eval(context), self._stamps.Eval(context))

    def _arriving(self, context: Context) -> Sample:
        sample, last = self._measured(context), self._last.read(context)
        if not self._is_active(context):
            return sample
        return faulty(self._fault, sample, last if self._has_last(last) else sample)

    def _calc_sample(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._arriving(context).state)

    def _calc_stamps(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._arriving(context).stamps)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        if not self._is_active(context) or not self._has_last(self._last.read(context)):
            self._last.write(discrete, self._measured(context))
