"""The base's low-level controller."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.low_level.flight_memory import initial_memory
from aerodrake.model.low_level.inner_loop import InnerLoop, inner_loop
from aerodrake.model.low_level.outer_loop import OuterLoop, outer_loop
from aerodrake.model.low_level.thrust_allocation import allocate
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody, commanded_motion, rigid_body_effort
from aerodrake.scenario import Flight, Rotor

MEMORY, ACCELERATION = 0, 2
"""Groups of the state, which are in the order of what `inner_loop` returns."""


class FlightController(LeafSystem):
    """ESO-based position and attitude control of the base.

    Ports:
        in `state` (13 + 2 n): measured state.
        in `base_setpoint` (9): p_d, v_d, a_d in m, m/s, m/s^2. With the
            `position` interface p_d alone is heeded.
        in `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2. Without
            the feedforward it is not heeded.
        out `thrust_command` (k): N, per rotor.
        out `acceleration` (6): what the base is believed to have from this command
            until the next, without disturbances: of its origin, m/s^2 in the
            world, and angular, rad/s^2 in the base frame.
        out `specific_thrust` (1): m/s^2, collective thrust over mass that the
            rotors are believed to give at the next sample.
        out `reaction` (3): m/s^2, what moving the arm takes off the base's acceleration.
        out `disturbance` (6): what acts beside thrust and gravity, m/s^2 in the
            world: h of the position ESO, less what moving the arm takes. And h of
            the attitude ESO, rad/s^2 in the base frame.
        out `saturated` (1): 1 if `thrust_command` is less than the laws ask for,
            by the limit of tilt or those of the rotors (thrust, or torque about
            any axis), else 0.

        Whoever reads these at the instant of a sample reads what was computed at
        the sample before, since the one for this sample follows after `offset`.
    State:
        what the loops remember (30 + k), as `initial_memory` has it: observers,
        integral of the position error, last desired attitude and its rate, and
        the thrust that the rotors are believed to give at the next sample. And
        each output.
    Rate:
        `period`, after `offset`, so that it sees what the MPC commanded at
        the same sample.

    The observers see saturated thrust, which keeps them from winding up. The
    attitude observer sees what lagging rotors really give. The slower one of
    position sees the command: rotors that rise faster than they fall give more
    than that on average, and this is a disturbance to reject.

    With `feedforward` whole_body, the inverse dynamics of base and arm say what
    force and torque the commanded motion of the arm takes. Without it the
    controller knows a rigid body with its mass at the origin, and the observers
    find out the rest.

    Attributes:
        trim_acceleration: (6,) `acceleration` in trim. Without feedforward it is
            not zero: the observer knows why.

    Args:
        config: Gains and interface.
        rotor: Limits and lag of a rotor.
        vehicle: Inertia and trim.
        period: s.
        offset: s.
    """

    def __init__(
        self,
        config: Flight,
        rotor: Rotor,
        vehicle: VehicleModel,
        period: float,
        offset: float,
    ):
        super().__init__()
        self._outer = OuterLoop.make(config, rotor, vehicle, period)
        self._inner = InnerLoop.make(config, rotor, vehicle, period)
        is_fed = config.feedforward == "whole_body"
        self._whole_body = WholeBody(vehicle.plant) if is_fed else None

        trim = allocate(self._inner.rotors, vehicle.trim_wrench)
        known = vehicle.trim_wrench[1:] * is_fed
        trim_h = self._inner.inverse_inertia @ (known - vehicle.trim_wrench[1:])
        still = np.zeros(3)
        self.trim_acceleration = np.concatenate([still, -trim_h])

        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self._setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * vehicle.joints)
        self.DeclareDiscreteState(initial_memory(vehicle.p_B, trim_h, trim))
        for name, x_0 in (
            ("thrust_command", trim),
            ("acceleration", self.trim_acceleration),
            ("reaction", still),
            ("specific_thrust", [trim.sum() / vehicle.mass]),
            ("disturbance", np.concatenate([still, trim_h])),
            ("saturated", [0.0]),
        ):
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(x_0))
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last = context.get_discrete_state()
        x, believed = last.value(MEMORY), last.value(ACCELERATION)
        state = self._state.Eval(context)
        position, u_v, a_B = outer_loop(
            self._outer, x, believed, state, self._setpoint.Eval(context)
        )
        effort = self._effort(context, state, a_B)
        found = inner_loop(self._inner, x, believed, state, position, u_v, a_B, effort)
        for group, value in enumerate(found):
            discrete.set_value(group, value)

    def _effort(self, context: Context, state: np.ndarray, a_B: np.ndarray) -> np.ndarray:
        """(6,) or more: what it takes to give the base a_B and no angular acceleration."""
        if self._whole_body is None:
            return rigid_body_effort(self._inner.mass, self._inner.inertia, state, a_B)
        return self._whole_body.effort(
            *commanded_motion(state, self._joint_setpoint.Eval(context), a_B)
        )
