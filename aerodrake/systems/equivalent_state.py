"""Initial state of the equivalent model at each tick."""

from typing import Annotated, NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.equivalent.initial_state import Signals, Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.support.arguments import Timed, checked
from aerodrake.systems.named_state import NamedState


class LastTick(NamedTuple):
    """Discrete state of `EquivalentState`.

    Attributes:
        x_0: (nx,), x_0 of the last tick.
        is_valid: False before the first tick, and if x_0 has NaN or infinite entries.
    """

    x_0: np.ndarray
    is_valid: bool


class EquivalentState(LeafSystem):
    """Initial state x_0 of the equivalent model, from measurement, setpoints and the last tick.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `base_setpoint` (9): [p_d, v_d, a_d] in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): [q_d, q_d', q_d''] in rad, rad/s, rad/s^2. In both setpoints
            the accelerations are those applied until the tick.
        in `external_acceleration` (3): m/s^2, of the sensors.
        in `disturbance` (6): of the flight controller, m/s^2 first.
        in `specific_thrust` (1): m/s^2, of the flight controller.
        out `x_0` (nx): state of the equivalent model at a tick. Direct feedthrough, so that
            systems that sample it at a tick have no delay; between ticks it has no meaning.
    State:
        groups of a `LastTick`.
    Rate:
        the model's period.

    Args:
        model: The equivalent model.
    """

    @checked
    def __init__(self, model: Annotated[EquivalentModel, Timed("dt")]):
        super().__init__()
        self._model = model
        n, nx = model.joints, len(model.A)
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._external_acceleration = self.DeclareVectorInputPort("external_acceleration", 3)
        self._disturbance = self.DeclareVectorInputPort("disturbance", 6)
        self._specific_thrust = self.DeclareVectorInputPort("specific_thrust", 1)
        self._last = NamedState(self, LastTick(np.zeros(nx), False))
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
        setpoints = self._base_setpoint.Eval(context), self._joint_setpoint.Eval(context)
        signals = Signals(state.p_B, state.v_B, *setpoints, thrust)
        last = self._last.read(context)
        x_0 = self._model.initial_state(signals, last.x_0 if last.is_valid else None)
        output.SetFromVector(x_0)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        x_0 = self._x_0.Eval(context)
        self._last.write(discrete, LastTick(x_0, bool(np.isfinite(x_0).all())))
