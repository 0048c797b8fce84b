"""Sensors that sample the vehicle's state for all its consumers."""

from functools import partial
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, LeafSystem, State

from aerodrake.model.sensing.encoder import Encoder, differentiated, quantized
from aerodrake.model.sensing.inertial import walked
from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import (
    ATTITUDE,
    GROUPS,
    INERTIAL_NOISE,
    JOINTS,
    Deviations,
    Sample,
    moved_back,
    noise_size,
    noisy,
    replace_group,
    sampled,
    split_inertial_noise,
)
from aerodrake.model.sensing.sensor_errors import SensorErrors, biased
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import AttitudeSensor, JointSensors, PositionSensor, Sensors
from aerodrake.support.arguments import Count, Duration, Period, StateVector, checked
from aerodrake.support.errors import BadInput
from aerodrake.systems.named_state import NamedState


def is_exact(config: Sensors) -> bool:
    """Returns True if samples have neither noise nor the resolution of encoders.

    They may be delayed, and have constant errors, such as biases.
    """
    return not any(Deviations.make(config)) and Encoder.make(config.joints) == Encoder.exact()


class SensorState(NamedTuple):
    """State of the sensors.

    Attributes:
        state: (13 + 2 n,) of the last sample.
        stamps: (3,) s, its time stamps.
        start: (13 + 2 n,) the true state at the start of the simulation.
        start_s: s, time of the start.
        is_sampling: True from the first periodic sample on.
        rate_bias: (3,) rad/s, of the gyroscope.
    """

    state: np.ndarray
    stamps: np.ndarray
    start: np.ndarray
    start_s: float
    is_sampling: bool
    rate_bias: np.ndarray


class SensorSystem(LeafSystem):
    """Samples and holds the state, with the scenario's measurement noise and flaws.

    The sample of time 0 is without noise. Before time 0 the base is assumed to have moved at its
    velocity of time 0; a delayed sample contains this motion.

    Ports:
        in `true_state` (13 + 2 n): `VehicleState` of the plant; its arm is sampled.
        in `late_state` (13 + 2 n): the plant's state, possibly delayed; its base is sampled.
        in `noise` (12 + n): standard normal draws, new at each sample.
        in `draws` (10): uniform, for latency and loss. Without either there is no such port.
        in `inertial_noise` (9): standard normal draws, in the order of `InertialNoise`. Without
            drift there is no such port.
        out `state` (13 + 2 n): the last sample.
        out `stamps` (3): s, when position, attitude and joints were sampled, without the delay; or
            when they arrived.
    State:
        the fields of a `SensorState`, a group each.
    Rate:
        `period`, or a group's own period, by discrete updates, each as long before a multiple of
        the period as `offset` is before `period`. And when a Simulator is initialised, before the
        first of them, by an unrestricted update, so that a Context may start in any state.

    Args:
        config: Standard deviations of the noise, and flaws.
        joints: n.
        period: s.
        offset: s, time of the first sample. If slightly less than the period, each sample
            precedes all other events at a multiple of the period.
        initial: (13 + 2 n,) the sample before the initialisation.
        delivery: Latency and loss; None for `late_state` of the known delay.
    """

    @checked
    def __init__(
        self,
        config: Sensors,
        joints: Count,
        period: Period,
        offset: Duration,
        initial: StateVector,
        delivery: Delivery | None = None,
    ):
        super().__init__()
        self._deviations, self._errors = Deviations.make(config), SensorErrors.make(config, joints)
        self._encoder, self._delivery = Encoder.make(config.joints), delivery
        self._is_exact, self._drift = is_exact(config), config.attitude.rate_drift_rad_s2
        flaws = config.position, config.attitude, config.joints
        self._has_errors = flaws != (PositionSensor(), AttitudeSensor(), JointSensors())
        self._delay_s = 0.0 if delivery else config.base_delay_s
        # Time from an update to the instant that it samples.
        self._lead = period - offset
        self._periods = [config.each[group].period_s or period for group in GROUPS]
        size = VehicleState.size(joints)
        if len(initial) != size:
            expected = f"expected {size} numbers for {joints} joints"
            raise BadInput("SensorSystem", "initial", f"{expected}, got {len(initial)}")
        self._true_state = self.DeclareVectorInputPort("true_state", size)
        self._late_state = self.DeclareVectorInputPort("late_state", size)
        self._noise = self.DeclareVectorInputPort("noise", noise_size(joints))
        if delivery:
            self._draws = self.DeclareVectorInputPort("draws", DRAWS)
        if self._drift > 0:
            self._inertial_noise = self.DeclareVectorInputPort("inertial_noise", INERTIAL_NOISE)
        stamps = np.full(3, offset - period)
        rate_bias = np.array(config.attitude.rate_bias_rad_s)
        first = SensorState(initial, stamps, initial, 0.0, False, rate_bias)
        self._last = NamedState(self, first)
        for name in Sample._fields:
            self.DeclareStateOutputPort(name, self._last.groups[name])
        self.DeclareInitializationUnrestrictedUpdateEvent(self._start)
        for own in sorted(set(self._periods)):
            groups = tuple(g for g, other in enumerate(self._periods) if other == own)
            is_all = len(groups) == len(GROUPS)
            sample = self._sample if is_all else partial(self._sample_groups, groups)
            self.DeclarePeriodicDiscreteUpdateEvent(own, own - self._lead, sample)

    def _start(self, context: Context, state: State) -> EventStatus:
        last = self._last.read(context)
        if last.is_sampling:  # A Context from within a flight.
            return EventStatus.DidNothing()
        start = self._true_state.Eval(context)
        first = moved_back(start, self._delay_s)
        if self._has_errors:
            first = biased(self._errors, last.rate_bias, first)
            q = split_state(first).q
            q[:] = quantized(self._encoder, q)
        started = last._replace(state=first, start=start, start_s=context.get_time())
        self._last.write(state.get_mutable_discrete_state(), started)
        return EventStatus.Succeeded()

    def _sample(self, context: Context, discrete: DiscreteValues) -> None:
        self._sample_groups(tuple(range(len(GROUPS))), context, discrete)

    def _sample_groups(
        self, groups: tuple[int, ...], context: Context, discrete: DiscreteValues
    ) -> None:
        # Other groups may have been sampled at the same instant.
        time, last = context.get_time(), self._last.read(discrete)
        missing_s = self._delay_s - (time + self._lead - last.start_s)
        is_before = missing_s > 1e-9  # The delay line has no state of then.
        base = moved_back(last.start, missing_s) if is_before else self._late_state.Eval(context)
        x, rate_bias = sampled(self._true_state.Eval(context), base), last.rate_bias
        if self._drift > 0 and ATTITUDE in groups:
            walk = split_inertial_noise(self._inertial_noise.Eval(context)).rate_walk
            rate_bias = walked(rate_bias, self._drift, walk, self._periods[ATTITUDE])
        if self._has_errors:
            x = biased(self._errors, rate_bias, x)
        if not self._is_exact:
            x = noisy(self._deviations, x, self._noise.Eval(context))
        state, stamps = last.state.copy(), last.stamps.copy()
        for g in groups:
            stamp = self._stamp(context, g, time)
            if stamp <= last.stamps[g]:
                continue
            if g == JOINTS and self._has_errors:
                self._encode(x, last.state, stamp - last.stamps[g])
            replace_group(g, state, x)
            stamps[g] = stamp
        now = last._replace(state=state, stamps=stamps, is_sampling=True, rate_bias=rate_bias)
        self._last.write(discrete, now)

    def _stamp(self, context: Context, g: int, time: float) -> float:
        """Returns the time stamp in s of a group that is due; minus infinity if it is lost."""
        if self._delivery is None:
            return time
        draws = self._draws.Eval(context)
        is_lost = self._delivery.is_lost(g, draws)
        return -np.inf if is_lost else self._delivery.stamp(g, time, draws)

    def _encode(self, x: np.ndarray, last: np.ndarray, dt: float) -> None:
        """Replaces the joints of x by what the encoders measure, `dt` s after the sample `last`."""
        joints, before = split_state(x), split_state(last)
        joints.q[:] = quantized(self._encoder, joints.q)
        if self._encoder.is_difference:
            rates = differentiated(self._encoder, before.qdot, before.q, joints.q, dt)
            joints.qdot[:] = rates
