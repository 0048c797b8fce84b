"""Sensors that sample the vehicle's state for all its consumers."""

import dataclasses

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.sample import Deviations, Sample, noise_size, noisy, sampled
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Sensors
from aerodrake.systems.named_state import NamedState


def is_exact(config: Sensors) -> bool:
    """Returns True if samples have no noise; they may be delayed."""
    return dataclasses.replace(config, base_delay_s=0.0) == Sensors()


class SensorSystem(LeafSystem):
    """Samples and holds the state, with the scenario's measurement noise.

    Ports:
        in `true_state` (13 + 2 n): the plant's state; its arm is sampled.
        in `late_state` (13 + 2 n): the plant's state, possibly delayed; its base is sampled.
        in `noise` (12 + n): standard normal draws, new at each sample.
        out `state` (13 + 2 n): the last sample.
        out `stamps` (3): s, when position, attitude and joints were sampled, without the delay.
    State:
        `state` (13 + 2 n) and `stamps` (3) of the last sample.
    Rate:
        `period`, after `offset`, by a discrete update.

    Args:
        config: Standard deviations of the noise.
        joints: n.
        period: s.
        offset: s, time of the first sample. If slightly less than the period, each sample
            precedes all other events at a multiple of the period, and `initial` is the
            sample at time 0.
        initial: (13 + 2 n,) the sample before the first.
    """

    def __init__(
        self, config: Sensors, joints: int, period: float, offset: float, initial: np.ndarray
    ):
        super().__init__()
        self._deviations = Deviations.make(config)
        self._is_exact = is_exact(config)
        size = VehicleState.size(joints)
        self._true_state = self.DeclareVectorInputPort("true_state", size)
        self._late_state = self.DeclareVectorInputPort("late_state", size)
        self._noise = self.DeclareVectorInputPort("noise", noise_size(joints))
        self._last = NamedState(self, Sample(initial, np.full(3, offset - period)))
        for name, group in self._last.groups.items():
            self.DeclareStateOutputPort(name, group)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._sample)

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        x = sampled(self._true_state.Eval(context), self._late_state.Eval(context))
        if not self._is_exact:
            x = noisy(self._deviations, x, self._noise.Eval(context))
        self._last.write(discrete, Sample(x, np.full(3, context.get_time())))
