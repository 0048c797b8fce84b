"""The base's low-level controller."""

from __future__ import annotations

import numpy as np
from pydrake.math import RotationMatrix
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
from aerodrake.scenario import Flight, Rotor


class FlightController(LeafSystem):
    """ESO-based position and attitude control of the base.

    Ports:
        in `state` (13 + 2 n): measured state.
        in `base_setpoint` (9): p_d, v_d, a_d in m, m/s, m/s^2. With the
            `position` interface p_d alone is heeded.
        out `thrust_command` (k): N, per rotor.
        out `disturbance` (6): h of the position ESO, m/s^2 in the world, and
            of the attitude ESO, rad/s^2 in the base frame.
        out `saturated` (1): 1 if `thrust_command` is less than the laws ask for,
            by the limit of tilt or those of the rotors (thrust, or torque about
            any axis), else 0. Whoever reads it at the instant of a sample reads
            that of the command before, since the one for this sample follows
            after `offset`.
    State:
        `position_eso` (3, 3), `attitude_eso` (2, 3), `integral` (3) of the
        position error, `thrust` (k) that the rotors are believed to give,
        `thrust_command` (k), `R_d` (3, 3), the last desired attitude,
        `omega_d` (3) rad/s, its filtered rate, in its own frame, and
        `saturated` (1).
    Rate:
        `period`, after `offset`, so that it sees what the MPC commanded at
        the same sample.

    The observers see saturated thrust, which keeps them from winding up. The
    attitude observer sees what lagging rotors really give. The slower one of
    position sees the command: rotors that rise faster than they fall give more
    than that on average, and this is a disturbance to reject.

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

        trim = self._allocation.allocate(vehicle.trim_wrench)
        trim_h = -self._inverse_inertia @ vehicle.trim_wrench[1:]
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self._setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._x_position = self.DeclareDiscreteState(np.concatenate([vehicle.p_B, np.zeros(6)]))
        self._x_attitude = self.DeclareDiscreteState(np.concatenate([np.zeros(3), trim_h]))
        self._x_integral = self.DeclareDiscreteState(np.zeros(3))
        self._x_thrust = self.DeclareDiscreteState(trim)
        self._x_command = self.DeclareDiscreteState(trim)
        self._x_R_d = self.DeclareDiscreteState(np.eye(3).ravel())
        self._x_omega_d = self.DeclareDiscreteState(np.zeros(3))
        self._x_saturated = self.DeclareDiscreteState(np.zeros(1))
        self._smoothing = period / (period + config.rate_filter_s)
        self.DeclareStateOutputPort("thrust_command", self._x_command)
        self.DeclareVectorOutputPort(
            "disturbance",
            6,
            self._calc_disturbance,
            {
                self.discrete_state_ticket(self._x_position),
                self.discrete_state_ticket(self._x_attitude),
            },
        )
        self.DeclareStateOutputPort("saturated", self._x_saturated)
        self.DeclarePeriodicDiscreteUpdateEvent(period, offset, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        config, vehicle = self._config, self._vehicle
        old = context.get_discrete_state
        state = VehicleState.from_vector(self._state.Eval(context))
        p_d, v_d, a_d = np.split(self._setpoint.Eval(context), 3)
        if config.interface == "position":
            v_d = a_d = np.zeros(3)
        R = state.R_B
        omega = R.T @ state.omega_W

        # What the rotors gave since the last sample.
        thrust, mean = self._lag.advance(old(self._x_thrust).value(), old(self._x_command).value())
        wrench = self._allocation.mixer @ mean
        commanded = self._allocation.mixer[0] @ old(self._x_command).value()
        gyroscopic = np.cross(omega, vehicle.inertia @ omega)

        position_eso = self._position_eso.step(
            old(self._x_position).value().reshape(3, 3),
            R[:, 2] * (commanded / vehicle.mass) - GRAVITY * UP,
            state.p_B,
        )
        attitude_eso = self._attitude_eso.step(
            old(self._x_attitude).value().reshape(2, 3),
            self._inverse_inertia @ (wrench[1:] - gyroscopic),
            omega,
        )

        error = state.p_B - p_d
        integral = old(self._x_integral).value()
        u_v = position_law(config, error, state.v_B - v_d, a_d, position_eso[-1], integral)
        f = desired_thrust(u_v, config.max_tilt_rad)
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
            [[vehicle.mass * (f @ R[:, 2])], vehicle.inertia @ u_omega + gyroscopic]
        )
        command = self._allocation.allocate(wanted)
        saturated = not np.allclose(f, u_v + GRAVITY * UP) or not np.allclose(
            self._allocation.mixer @ command, wanted
        )
        if not saturated:
            integral = integral + self._period * error

        for index, value in (
            (self._x_position, position_eso.ravel()),
            (self._x_attitude, attitude_eso.ravel()),
            (self._x_integral, integral),
            (self._x_thrust, thrust),
            (self._x_command, command),
            (self._x_R_d, R_d.ravel()),
            (self._x_omega_d, omega_d),
            (self._x_saturated, [saturated]),
        ):
            discrete.set_value(index, value)

    def _calc_disturbance(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(
            np.concatenate(
                [
                    context.get_discrete_state(self._x_position).value()[-3:],
                    context.get_discrete_state(self._x_attitude).value()[-3:],
                ]
            )
        )
