"""Sensors that sample the vehicle's state for all its consumers."""

import dataclasses
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, LeafSystem, State

from aerodrake.model.sensing.sample import (
    Deviations,
    Sample,
    moved_back,
    noise_size,
    noisy,
    sampled,
)
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Sensors
from aerodrake.support.arguments import Count, Duration, Period, StateVector, checked
from aerodrake.support.errors import BadInput
from aerodrake.systems.named_state import NamedState


def is_exact(config: Sensors) -> bool:
    """Returns True if samples have no noise; they may be delayed."""
    return dataclasses.replace(config, base_delay_s=0.0) == Sensors()


class SensorState(NamedTuple):
    """State of the sensors.

    Attributes:
        state: (13 + 2 n,) of the last sample.
        stamps: (3,) s, its time stamps.
        start: (13 + 2 n,) the true state at the start of the simulation.
        start_s: s, time of the start.
        is_sampling: True from the first periodic sample on.
    """

    state: np.ndarray
    stamps: np.ndarray
    start: np.ndarray
    start_s: float
    is_sampling: bool


class SensorSystem(LeafSystem):
    """Samples and holds the state, with the scenario's measurement noise.

    The sample of time 0 is exact. Before time 0 the base is assumed to have moved at its
    velocity of time 0; a delayed sample contains this motion.

    Ports:
        in `true_state` (13 + 2 n): `VehicleState` of the plant; its arm is sampled.
        in `late_state` (13 + 2 n): the plant's state, possibly delayed; its base is sampled.
        in `noise` (12 + n): standard normal draws, new at each sample.
        out `state` (13 + 2 n): the last sample.
        out `stamps` (3): s, when position, attitude and joints were sampled, without the delay.
    State:
        the fields of a `SensorState`, a group each.
    Rate:
        `period`, after `offset`, by a discrete update. And when a Simulator is initialised, before
        the first of them, by an unrestricted update, so that a Context may start in any state.

    Args:
        config: Standard deviations of the noise.
        joints: n.
        period: s.
        offset: s, time of the first sample. If slightly less than the period, each sample
            precedes all other events at a multiple of the period.
        initial: (13 + 2 n,) the sample before the initialisation.
    """

    @checked
    def __init__(
        self, config: Sensors, joints: Count, period: Period, offset: Duration, initial: StateVector
    ):
        super().__init__()
        self._deviations = Deviations.make(config)
        self._is_exact, self._delay_s = is_exact(config), config.base_delay_s
        # Time from an update to the instant that it samples.
        self._lead = period - offset
        size = VehicleState.size(joints)
        if len(initial) != size:
            expected = f"expected {size} numbers for {joints} joints"
            raise BadInput("SensorSystem", "initial", f"{expected}, got {len(initial)}")
        self._true_state = self.DeclareVectorInputPort("true_state", size)
        self._late_state = self.DeclareVectorInputPort("late_state", size)
        self._noise = self.DeclareVectorInputPort("noise", noise_size(joints))
        first = SensorState(initial, np.full(3, offset - period), initial, 0.0, False)
        self._last = NamedState(self, first)
        for name in Sample._fields:
            self.DeclareStateOutputPort(name, self._last.groups[name])
        self.DeclareInitializationUnrestrictedUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._sample)

    def _start(self, context: Context, state: State) -> EventStatus:
        last = self._last.read(context)
        if last.is_sampling:  # A Context from within a flight.
            return EventStatus.DidNothing()
        start = self._true_state.Eval(context)
        started = last._replace(
            state=moved_back(start, self._delay_s), start=start, start_s=context.get_time()
        )
        self._last.write(state.get_mutable_discrete_state(), started)
        return EventStatus.Succeeded()

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        time, last = context.get_time(), self._last.read(context)
        missing_s = self._delay_s - (time + self._lead - last.start_s)
        is_before = missing_s > 1e-9  # The delay line has no state of then.
        base = moved_back(last.start, missing_s) if is_before else self._late_state.Eval(context)
        x = sampled(self._true_state.Eval(context), base)
        if not self._is_exact:
            x = noisy(self._deviations, x, self._noise.Eval(context))
        stamps = np.full(3, time)
        self._last.write(discrete, last._replace(state=x, stamps=stamps, is_sampling=True))
