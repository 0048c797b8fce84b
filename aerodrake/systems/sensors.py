"""Samples of the vehicle's state, shared by everything that looks at it."""

from __future__ import annotations

import dataclasses

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.sample import Deviations, disturbed, noise_size, sampled
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Sensors

SAMPLE, STAMPS = 0, 1
"""Groups of the state."""


def is_exact(config: Sensors) -> bool:
    """Whether samples have no noise, late or not."""
    return dataclasses.replace(config, base_delay_s=0.0) == Sensors()


class SensorSystem(LeafSystem):
    """Samples the state and holds it: exact by default, noisy if the scenario says so.

    Ports:
        in `true_state` (13 + 2 n): the plant's state, of which the arm's is sampled.
        in `late_state` (13 + 2 n): the same or an earlier one, of which the base's is.
        in `noise` (12 + n): standard normal draws, new at each sample.
        out `state` (13 + 2 n): the last sample.
        out `stamps` (3): s, when its groups were taken: position, attitude, joints.
    State:
        the last sample, and when it was taken.
    Rate:
        `period`, after `offset`, by a discrete update.

    Args:
        config: Standard deviations of the noise.
        joints: n.
        period: s.
        offset: s, when the first sample is taken. With a little less than the
            period a sample is there when all else happens that is due at its
            multiples; what was `initial` is the sample at time 0.
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
        self.DeclareStateOutputPort("state", self.DeclareDiscreteState(initial))
        stamps = self.DeclareDiscreteState(np.full(3, offset - period))
        self.DeclareStateOutputPort("stamps", stamps)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._sample)

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        x = sampled(self._true_state.Eval(context), self._late_state.Eval(context))
        if not self._is_exact:
            x = disturbed(self._deviations, x, self._noise.Eval(context))
        discrete.set_value(SAMPLE, x)
        discrete.set_value(STAMPS, np.full(3, context.get_time()))
