"""The state of the equivalent model as a system."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.equivalent.initial_state import Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.vehicle.state import VehicleState, split_state


class EquivalentState(LeafSystem):
    """x_0 of the equivalent model, from measurement, command and the tick before.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `base_setpoint` (9): [p_d, v_d, a_d] in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): [q_d, q_d', q_d''] in rad, rad/s, rad/s^2. The
            accelerations of both are those held up to a tick.
        in `external_acceleration` (3): m/s^2, of the sensors.
        in `disturbance` (6): of the flight controller, m/s^2 first.
        in `specific_thrust` (1): m/s^2, of the flight controller.
        out `x_0` (nx). It feeds through, so that whoever samples it at a tick
            has it without delay; between ticks it means nothing.
    State:
        `last` (nx), x_0 of the tick before, and whether there was one (0 or 1).
        One that was not finite does not count.
    Rate:
        the model's period.

    Args:
        model: Whose state it is.
    """

    def __init__(self, model: EquivalentModel):
        super().__init__()
        self._model = model
        n, nx = model.joints, len(model.A)
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._external_acceleration = self.DeclareVectorInputPort("external_acceleration", 3)
        self._disturbance = self.DeclareVectorInputPort("disturbance", 6)
        self._specific_thrust = self.DeclareVectorInputPort("specific_thrust", 1)
        self._last = self.DeclareDiscreteState(np.zeros(nx))
        self._known = self.DeclareDiscreteState(np.zeros(1))
        prerequisites = {self.all_input_ports_ticket(), self.xd_ticket()}
        self._x_0 = self.DeclareVectorOutputPort("x_0", nx, self._calc_x_0, prerequisites)
        self.DeclarePeriodicDiscreteUpdateEvent(model.dt, 0.0, self._update)

    def _calc_x_0(self, context: Context, output: BasicVector) -> None:
        state = split_state(self._state.Eval(context))
        thrust = Thrust.make(
            state,
            self._specific_thrust.Eval(context)[0],
            self._external_acceleration.Eval(context),
            self._disturbance.Eval(context),
        )
        is_known = context.get_discrete_state(self._known).value()[0] > 0.5
        output.SetFromVector(
            self._model.initial_state(
                state.p_B,
                state.v_B,
                self._base_setpoint.Eval(context),
                self._joint_setpoint.Eval(context),
                thrust,
                context.get_discrete_state(self._last).value() if is_known else None,
            )
        )

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        x_0 = self._x_0.Eval(context)
        discrete.set_value(self._last, x_0)
        discrete.set_value(self._known, [np.isfinite(x_0).all()])
