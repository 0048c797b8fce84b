"""The base's low-level controller."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydrake.math import RotationMatrix, VectorToSkewSymmetric
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.eso import ExtendedStateObserver
from aerodrake.model.flight_law import (
    UP,
    attitude_error,
    attitude_law,
    desired_attitude,
    desired_thrust,
    position_law,
)
from aerodrake.model.rotor_lag import RotorLag
from aerodrake.model.thrust_allocation import ThrustAllocation
from aerodrake.model.vehicle import GRAVITY, Vehicle
from aerodrake.model.vehicle_state import VehicleState
from aerodrake.model.whole_body import WholeBody
from aerodrake.scenario import Flight, Rotor

UNSATURATED = 1e-6
"""m/s^2, N or N m: what a command may miss by rounding."""


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
        `position_eso` (3, 3), `attitude_eso` (2, 3), `integral` (3) of the
        position error, `thrust` (k) that the rotors are believed to give at the
        next sample, `thrust_command` (k), `acceleration` (6), `reaction` (3) of
        the arm, m/s^2, `R_d` (3, 3), the last desired attitude, `omega_d` (3)
        rad/s, its filtered rate, in its own frame, and `saturated` (1).
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
        vehicle: Vehicle,
        period: float,
        offset: float,
    ):
        super().__init__()
        self._config = config
        self._vehicle = vehicle
        self._period = period
        self._inverse_inertia = np.linalg.inv(vehicle.inertia)
        self._allocation = ThrustAllocation.make(vehicle, rotor)
        self._lag = RotorLag(rotor.lag_up_s, rotor.lag_down_s, period)
        self._position_eso = ExtendedStateObserver(2, config.position_eso_rad_s, period)
        self._attitude_eso = ExtendedStateObserver(1, config.attitude_eso_rad_s, period)

        self._most_thrust = len(vehicle.rotors.names) * rotor.max_thrust_n / vehicle.mass
        trim = self._allocation.allocate(vehicle.trim_wrench)
        is_fed = config.feedforward == "whole_body"
        self._whole_body = WholeBody(vehicle.robot) if is_fed else None
        known = vehicle.trim_wrench[1:] * is_fed
        trim_h = self._inverse_inertia @ (known - vehicle.trim_wrench[1:])
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self._setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * vehicle.joints)
        self._x_position = self.DeclareDiscreteState(np.concatenate([vehicle.p_B, np.zeros(6)]))
        self._x_attitude = self.DeclareDiscreteState(np.concatenate([np.zeros(3), trim_h]))
        self._x_integral = self.DeclareDiscreteState(np.zeros(3))
        self._x_thrust = self.DeclareDiscreteState(trim)
        self._x_command = self.DeclareDiscreteState(trim)
        self.trim_acceleration = np.concatenate([np.zeros(3), -trim_h])
        self._x_acceleration = self.DeclareDiscreteState(self.trim_acceleration)
        self._x_reaction = self.DeclareDiscreteState(np.zeros(3))
        self._x_R_d = self.DeclareDiscreteState(np.eye(3).ravel())
        self._x_omega_d = self.DeclareDiscreteState(np.zeros(3))
        self._x_saturated = self.DeclareDiscreteState(np.zeros(1))
        self._smoothing = period / (period + config.rate_filter_s)
        self.DeclareStateOutputPort("thrust_command", self._x_command)
        self.DeclareStateOutputPort("acceleration", self._x_acceleration)
        self.DeclareStateOutputPort("reaction", self._x_reaction)
        self.DeclareVectorOutputPort(
            "specific_thrust",
            1,
            self._calc_specific_thrust,
            {self.discrete_state_ticket(self._x_thrust)},
        )
        self.DeclareVectorOutputPort(
            "disturbance",
            6,
            self._calc_disturbance,
            {
                self.discrete_state_ticket(self._x_position),
                self.discrete_state_ticket(self._x_attitude),
                self.discrete_state_ticket(self._x_reaction),
            },
        )
        self.DeclareStateOutputPort("saturated", self._x_saturated)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        config, vehicle = self._config, self._vehicle
        old = context.get_discrete_state
        state = VehicleState.from_vector(self._state.Eval(context))
        p_d, v_d, a_d = self._setpoint.Eval(context).reshape(3, -1)
        if config.interface == "position":
            v_d = a_d = np.zeros(3)
        R = state.R_B
        omega = R.T @ state.omega_W

        # What the rotors gave since the last sample.
        linear, angular = old(self._x_acceleration).value().reshape(2, 3)
        position_eso = self._position_eso.step(
            old(self._x_position).value().reshape(3, 3), linear, state.p_B
        )
        attitude_eso = self._attitude_eso.step(
            old(self._x_attitude).value().reshape(2, 3), angular, omega
        )

        error = state.p_B - p_d
        integral = old(self._x_integral).value()
        u_v = position_law(config, error, state.v_B - v_d, a_d, position_eso[-1], integral)
        reaction, torque = self._reaction(context, state, u_v)
        f = desired_thrust(u_v + reaction, config.max_tilt_rad)
        R_d = desired_attitude(f)
        R_d_last = old(self._x_R_d).value().reshape(3, 3)
        turned = RotationMatrix(R_d_last.T @ R_d).ToAngleAxis()
        omega_d = old(self._x_omega_d).value()
        omega_d = omega_d + self._smoothing * (
            turned.axis() * (turned.angle() / self._period) - omega_d
        )
        rate_error = omega - R.T @ R_d @ omega_d
        u_omega = attitude_law(config, attitude_error(R, R_d), rate_error, attitude_eso[-1])

        wanted = np.concatenate(
            [[vehicle.mass * (f @ R[:, 2])], vehicle.inertia @ u_omega + torque]
        )
        command = self._allocation.allocate(wanted)
        missing = np.append(
            u_v + reaction + GRAVITY * UP - f, wanted - self._allocation.mixer @ command
        )
        saturated = not np.abs(missing).max() <= UNSATURATED
        thrust, mean = self._lag.advance(old(self._x_thrust).value(), command)
        lift, turn = self._allocation.mixer @ command, self._allocation.mixer @ mean
        halfway = R[:, 2] + (VectorToSkewSymmetric(state.omega_W) @ R[:, 2]) * (self._period / 2)
        acceleration = np.concatenate(
            [
                halfway * (lift[0] / vehicle.mass) - GRAVITY * UP - reaction,
                self._inverse_inertia @ (turn[1:] - torque),
            ]
        )
        if not saturated:
            integral = integral + self._period * error

        for index, value in (
            (self._x_position, position_eso.ravel()),
            (self._x_attitude, attitude_eso.ravel()),
            (self._x_integral, integral),
            (self._x_thrust, thrust),
            (self._x_command, command),
            (self._x_acceleration, acceleration),
            (self._x_reaction, reaction),
            (self._x_R_d, R_d.ravel()),
            (self._x_omega_d, omega_d),
            (self._x_saturated, [saturated]),
        ):
            discrete.set_value(index, value)

    def _attainable(self, u_v: np.ndarray) -> np.ndarray:
        """(3,) m/s^2, as much of u_v as tilt and thrust allow."""
        thrust = desired_thrust(u_v, self._config.max_tilt_rad)
        return thrust * min(1.0, self._most_thrust / np.linalg.norm(thrust)) - GRAVITY * UP

    def _reaction(
        self, context: Context, state: VehicleState, u_v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What base and arm take to move as commanded without turning, beyond a point mass.

        Returns:
            (3,) m/s^2, force over mass beyond what u_v can be had of and gravity, in
            the world, and (3,) N m, torque in the base frame.
        """
        if self._whole_body is None:
            omega = state.R_B.T @ state.omega_W
            return np.zeros(3), VectorToSkewSymmetric(omega) @ self._vehicle.inertia @ omega
        a_B = self._attainable(u_v)
        q_d, qdot_d, qddot_d = self._joint_setpoint.Eval(context).reshape(3, -1)
        # The commanded arm, since the measured one is noisier than its lag is long.
        effort = self._whole_body.effort(replace(state, q=q_d, qdot=qdot_d), a_B, qddot_d)
        return effort.force / self._vehicle.mass - a_B - GRAVITY * UP, effort.torque

    def _calc_specific_thrust(self, context: Context, output: BasicVector) -> None:
        thrust = context.get_discrete_state(self._x_thrust).value()
        output.SetFromVector([thrust.sum() / self._vehicle.mass])

    def _calc_disturbance(self, context: Context, output: BasicVector) -> None:
        h = context.get_discrete_state(self._x_position).value()[-3:]
        reaction = context.get_discrete_state(self._x_reaction).value()
        h_omega = context.get_discrete_state(self._x_attitude).value()[-3:]
        output.SetFromVector(np.concatenate([h - reaction, h_omega]))
