"""State filter as a system."""

from typing import Annotated, NamedTuple

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, InputPort, LeafSystem, State

from aerodrake.model.sensing.sample import Sample
from aerodrake.model.sensing.state_filter import (
    NO_FORCE,
    FilterState,
    StateFilter,
    replace_rejected,
    update,
)
from aerodrake.model.vehicle.state import split_state
from aerodrake.support.arguments import StateVector, Timed, Vector6, checked
from aerodrake.systems.named_state import NamedState


class FilterOutputs(NamedTuple):
    """Outputs of the state filter beside its `FilterState`: state (13 + 2 n,), and
    external_acceleration (3,) m/s^2."""

    state: np.ndarray
    external_acceleration: np.ndarray


class StateFilterSystem(LeafSystem):
    """Estimates the vehicle's present state, for all its consumers, from samples.

    Groups of a sample that `state_filter.check` rejects are predicted.

    Ports:
        in `sample` (13 + 2 n): the last sample, a `VehicleState`; its base is
            `state_filter.steps` samples late.
        in `stamps` (3): s, when its position, attitude and joints were sampled.
        in `acceleration` (6): from the flight controller, the base's modelled acceleration
            since the last sample.
        in `reaction` (3): m/s^2, from the flight controller, contained in `acceleration`.
        in `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        in `specific_force` (3) and `specific_force_stamp` (1): m/s^2 in the base frame and s, from
            the accelerometer. Only a filter that uses one has these ports.
        out `state` (13 + 2 n): the estimated present `VehicleState`; the last sample if
            samples are exact.
        out `external_acceleration` (3): m/s^2 in the world, acceleration of the base beyond
            `acceleration`, by external forces; if thrust compensates the arm's reaction,
            that is included.
        out `sample_health` (6): by group, s since the last accepted sample (0 if this one is
            accepted), and the `Verdict`.
        out `joint_oscillation` (n): rad/s, amplitude with which each joint oscillates.
        out `position_offset` (3): m, sum of the steps by which resets have moved the estimated
            position. Setpoints move by the same steps, so that the vehicle does not.
    State:
        a group for each field of `FilterState`: of the sample check the previous sample,
        time stamps, accepted values, travel, health and jump; of the estimate disturbance and
        state; the accelerations since the base's last sample; the position offset; of the joints'
        oscillation half-waves and amplitude. And the other two outputs. With an accelerometer,
        `specific_force_stamp`, of its last mean.
    Rate:
        `state_filter.dt`, by an *unrestricted* update: these run before the discrete updates of
        the same instant, so that a controller that ticks with the sensors sees the new state.

    Args:
        state_filter: The equations.
        passes: True if `state` has the accepted groups of the sample itself.
        initial: (13 + 2 n,) the state before the first sample, at rest.
        trim_acceleration: (6,) modelled at rest; the initial disturbances cancel it.
    """

    @checked
    def __init__(
        self,
        state_filter: Annotated[StateFilter, Timed("dt")],
        passes: bool,
        initial: StateVector,
        trim_acceleration: Vector6,
    ):
        super().__init__()
        self._filter, self._passes = state_filter, passes
        self._sample = self.DeclareVectorInputPort("sample", len(initial))
        self._stamps = self.DeclareVectorInputPort("stamps", 3)
        self._acceleration = self.DeclareVectorInputPort("acceleration", 6)
        self._reaction = self.DeclareVectorInputPort("reaction", 3)
        joints = len(split_state(initial).q)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * joints)
        self._accelerometer: tuple[InputPort, InputPort, int] | None = None
        if len(state_filter.accelerometer):
            self._accelerometer = (
                self.DeclareVectorInputPort("specific_force", 3),
                self.DeclareVectorInputPort("specific_force_stamp", 1),
                self.DeclareDiscreteState([-np.inf]),
            )
        first = FilterState.before_samples(state_filter, initial, trim_acceleration)
        self._state = NamedState(self, first)
        self._outputs = NamedState(self, FilterOutputs(initial, np.zeros(3)))
        for name, group in self._outputs.groups.items():
            self.DeclareStateOutputPort(name, group)
        for name, part in (
            ("sample_health", "check.health"),
            ("joint_oscillation", "oscillation.amplitude"),
            ("position_offset", "position_offset"),
        ):
            self.DeclareStateOutputPort(name, self._state.groups[part])
        self.DeclarePeriodicUnrestrictedUpdateEvent(state_filter.dt, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        discrete = state.get_mutable_discrete_state()
        sample = Sample(self._sample.Eval(context), self._stamps.Eval(context))
        last, setpoint = self._state.read(context), self._joint_setpoint.Eval(context)
        acceleration = self._acceleration.Eval(context)
        force = self._specific_force(context, discrete)
        now, estimate = update(self._filter, last, sample, acceleration, setpoint, force)
        output = estimate.state
        if self._passes:
            output = replace_rejected(sample.state, estimate.state, now.check.health)
        external = estimate.disturbance[:3] - self._reaction.Eval(context)
        self._state.write(discrete, now)
        self._outputs.write(discrete, FilterOutputs(output, external))

    def _specific_force(self, context: Context, discrete: DiscreteValues) -> np.ndarray:
        """Returns the measured specific force (3,) m/s^2; NaN if there is no new one."""
        if self._accelerometer is None:
            return NO_FORCE
        force, stamp, group = self._accelerometer
        newest = stamp.Eval(context)
        if not newest > discrete.value(group):
            return NO_FORCE
        discrete.set_value(group, newest)
        return force.Eval(context)
