"""The state filter as a system."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from aerodrake.model.sensing.sample_check import SampleCheck
from aerodrake.model.sensing.state_filter import StateFilter, initial_memory, passed, update
from aerodrake.model.vehicle.state import VehicleState


class StateFilterSystem(LeafSystem):
    """What everybody takes for the vehicle's state: samples, filtered and brought up to date.

    Groups of a sample that are not believed, as `check` has it, are predicted.

    Ports:
        in `sample` (13 + 2 n): the last sample; its base is `filter.steps` late.
        in `stamps` (3): s, when its groups were taken: position, attitude, joints.
        in `acceleration` (6): of the flight controller, what the base is believed
            to have had since the last sample.
        in `reaction` (3): of the flight controller, m/s^2, part of `acceleration`.
        in `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        out `state` (13 + 2 n): the state now. If samples are exact, the last one.
        out `external_acceleration` (3): m/s^2 in the world, what accelerates the base
            beside thrust and gravity, the arm's reaction included.
        out `sample_health` (6): of each group, s from the last sample that was believed,
            0 if it is this one; and its `Verdict`.
    State:
        what the filter remembers, as its `initial_memory` has it; and what the
        outputs show.
    Rate:
        `period`, by an *unrestricted* update: these run before the discrete
        updates of the same instant, so that a controller that ticks together
        with the sensors sees the new state and not one that is a period old.

    Args:
        state_filter: The equations.
        sample_check: What is believed.
        passes: Whether `state` is the sample as it is, where that is believed.
        joints: n.
        initial: (13 + 2 n,) the state before the first sample, at rest.
        trim_acceleration: (6,) as modelled then; what it says is not there.
    """

    def __init__(
        self,
        state_filter: StateFilter,
        sample_check: SampleCheck,
        passes: bool,
        joints: int,
        initial: np.ndarray,
        trim_acceleration: np.ndarray,
    ):
        super().__init__()
        self._filter = state_filter
        self._check = sample_check
        self._passes = passes
        self._sample = self.DeclareVectorInputPort("sample", VehicleState.size(joints))
        self._stamps = self.DeclareVectorInputPort("stamps", 3)
        self._acceleration = self.DeclareVectorInputPort("acceleration", 6)
        self._reaction = self.DeclareVectorInputPort("reaction", 3)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * joints)
        self._x_memory = self.DeclareDiscreteState(
            initial_memory(state_filter, initial, trim_acceleration)
        )
        self._x_state = self.DeclareDiscreteState(initial)
        self.DeclareStateOutputPort("state", self._x_state)
        self._x_external = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("external_acceleration", self._x_external)
        self._x_health = self.DeclareDiscreteState(np.zeros(6))
        self.DeclareStateOutputPort("sample_health", self._x_health)
        self.DeclarePeriodicUnrestrictedUpdateEvent(state_filter.dt, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        discrete = state.get_mutable_discrete_state()
        sample = self._sample.Eval(context)
        memory, now, health = update(
            self._filter,
            self._check,
            discrete.value(self._x_memory),
            self._acceleration.Eval(context),
            sample,
            self._stamps.Eval(context),
            self._joint_setpoint.Eval(context),
        )
        shown = passed(sample, now[6:], health) if self._passes else now[6:]
        discrete.set_value(self._x_memory, memory)
        discrete.set_value(self._x_health, health)
        discrete.set_value(self._x_state, shown)
        discrete.set_value(self._x_external, now[:3] - self._reaction.Eval(context))
