"""Inner loop of the flight controller: from a desired acceleration to rotor thrusts."""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.low_level.eso import ExtendedStateObserver, observe
from aerodrake.model.low_level.flight_law import (
    FlightGains,
    attitude_error,
    attitude_law,
    desired_attitude,
    desired_thrust,
)
from aerodrake.model.low_level.flight_state import FlightOutputs, FlightState
from aerodrake.model.low_level.outer_loop import PositionCommand
from aerodrake.model.low_level.rotor_lag import RotorLag, advance
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle.rotation import UP, cross, rotation_matrix, turn
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Flight, Rotor
from aerodrake.support.compiled import compiled

SATURATION_TOLERANCE = 1e-6
"""m/s^2, N or N m: shortfall of a command that is attributed to rounding."""


class InnerLoop(NamedTuple):
    """Constants of the inner loop.

    Attributes:
        gains: Gains of the flight laws.
        eso: Attitude observer.
        rotors: Allocation of a wrench to the rotors.
        lag: Lag of the rotors' thrust.
        decay: Factor on collective thrust's deviation from its command over a period, with the mean
            lag.
        mass: kg, base and arm.
        inertia: (3, 3) kg m^2, base and arm.
        inverse_inertia: (3, 3).
        max_tilt: rad.
        smoothing: Weight of the new value in the filter of omega_d.
    """

    gains: FlightGains
    eso: ExtendedStateObserver
    rotors: ThrustAllocation
    lag: RotorLag
    decay: float
    mass: float
    inertia: np.ndarray
    inverse_inertia: np.ndarray
    max_tilt: float
    smoothing: float

    @classmethod
    def make(cls, config: Flight, rotor: Rotor, vehicle: VehicleModel, period: float) -> Self:
        """Returns the loop for a scenario's gains and a vehicle; `period` in s.

        Raises:
            BadInput: if the rotors cannot lift the vehicle without tilting it.
        """
        return cls(
            gains=FlightGains.make(config),
            eso=ExtendedStateObserver.make(1, config.attitude_eso_rad_s, period),
            rotors=ThrustAllocation.make(vehicle, rotor),
            lag=RotorLag(rotor.lag_up_s, rotor.lag_down_s, period),
            decay=math.exp(-2 * period / (rotor.lag_up_s + rotor.lag_down_s)),
            mass=vehicle.mass,
            inertia=np.ascontiguousarray(vehicle.inertia),
            inverse_inertia=np.linalg.inv(vehicle.inertia),
            max_tilt=config.max_tilt_rad,
            smoothing=period / (period + config.rate_filter_s),
        )


@compiled
def inner_loop(
    loop: InnerLoop,
    last: FlightState,
    state: np.ndarray,
    position: PositionCommand,
    effort: np.ndarray,
) -> tuple[FlightState, FlightOutputs]:
    """Runs attitude observer, attitude law and allocation, and models the acceleration.

    Args:
        loop: Constants.
        last: State of the flight controller.
        state: (13 + 2 n,) measured.
        position: Result of `outer_loop`.
        effort: (6,) or more, N m about the base's origin and N, in the world, that give the
            base `position.a_B` and no angular acceleration.
    """
    u_v, torque, force = position.u_v, effort[:3], effort[3:6]
    quaternion, _, _, omega_W, _, _ = split_state(state)
    R = rotation_matrix(quaternion)
    omega = R.T @ omega_W
    observer = observe(loop.eso, last.attitude_observer, last.acceleration[3:], omega)

    reaction = force / loop.mass - position.a_B - GRAVITY * UP
    torque = R.T @ torque
    f = desired_thrust(u_v + reaction, loop.max_tilt)
    R_d = desired_attitude(f)
    rate = turn(last.R_d.T @ R_d) / loop.lag.dt
    omega_d = last.omega_d + loop.smoothing * (rate - last.omega_d)
    rate_error = omega - R.T @ (R_d @ omega_d)
    u_omega = attitude_law(loop.gains, attitude_error(R, R_d), rate_error, observer[-1])

    z_B = R[:, 2].copy()
    lift = np.array([loop.mass * np.sum(f * z_B)])
    wrench = np.concatenate((lift, loop.inertia @ u_omega + torque))
    command = allocate(loop.rotors, wrench)
    allocated = loop.rotors.mixer @ command
    missing = np.concatenate((u_v + reaction + GRAVITY * UP - f, wrench - allocated))
    saturated = not np.abs(missing).max() <= SATURATION_TOLERANCE
    thrust, mean = advance(loop.lag, last.rotor_thrust, command)
    mean_wrench = loop.rotors.mixer @ mean
    commanded = allocated[0] / loop.mass
    specific = commanded + (last.specific_thrust - commanded) * loop.decay

    halfway = z_B + cross(omega_W, z_B) * (loop.lag.dt / 2)
    linear = halfway * commanded - GRAVITY * UP - reaction
    angular = loop.inverse_inertia @ (mean_wrench[1:] - torque)
    now = FlightState(
        position.observer,
        observer,
        last.position_integral if saturated else position.integral,
        R_d,
        omega_d,
        thrust,
        specific,
        np.concatenate((linear, angular)),
        last.joint_acceleration,
        last.p_B,
    )
    disturbance = np.concatenate((position.observer[-1] - reaction, observer[-1]))
    return now, FlightOutputs(command, reaction, disturbance, saturated)
