"""The inner loop of the flight controller: from the acceleration wanted to rotor thrusts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.low_level.eso import ExtendedStateObserver, observe
from aerodrake.model.low_level.flight_law import (
    AttitudeGains,
    attitude_error,
    attitude_law,
    desired_attitude,
    desired_thrust,
)
from aerodrake.model.low_level.flight_memory import memory_parts
from aerodrake.model.low_level.rotor_lag import RotorLag, advance
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle.rotation import UP, cross, rotation_matrix, turn
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Flight, Rotor
from aerodrake.support.compiled import compiled

UNSATURATED = 1e-6
"""m/s^2, N or N m: what a command may miss by rounding."""


class InnerLoop(NamedTuple):
    """Its constants.

    Attributes:
        gains: Of the attitude law.
        eso: The attitude observer.
        rotors: How a wrench is shared among them.
        lag: Of their thrust.
        mass: kg, base and arm.
        inertia: (3, 3) kg m^2, of both.
        inverse_inertia: (3, 3).
        max_tilt: rad.
        smoothing: How much of omega_d is new at each sample.
    """

    gains: AttitudeGains
    eso: ExtendedStateObserver
    rotors: ThrustAllocation
    lag: RotorLag
    mass: float
    inertia: np.ndarray
    inverse_inertia: np.ndarray
    max_tilt: float
    smoothing: float

    @classmethod
    def make(cls, config: Flight, rotor: Rotor, vehicle: VehicleModel, period: float) -> InnerLoop:
        """Of the scenario's gains and this vehicle; `period` in s.

        Raises:
            BadInput: if its rotors cannot lift it without tilting it.
        """
        return cls(
            gains=AttitudeGains.make(config),
            eso=ExtendedStateObserver.make(1, config.attitude_eso_rad_s, period),
            rotors=ThrustAllocation.make(vehicle, rotor),
            lag=RotorLag(rotor.lag_up_s, rotor.lag_down_s, period),
            mass=vehicle.mass,
            inertia=np.ascontiguousarray(vehicle.inertia),
            inverse_inertia=np.linalg.inv(vehicle.inertia),
            max_tilt=config.max_tilt_rad,
            smoothing=period / (period + config.rate_filter_s),
        )


@compiled
def inner_loop(
    loop: InnerLoop,
    x: np.ndarray,
    believed: np.ndarray,
    state: np.ndarray,
    position: np.ndarray,
    u_v: np.ndarray,
    a_B: np.ndarray,
    effort: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Attitude observer, attitude law, allocation, and what the base is believed to have of it.

    Args:
        loop: Its constants.
        x, believed, state: (30 + k,), (6,) and (13 + 2 n,), as `outer_loop` has them.
        position, u_v, a_B: (12,), (3,) m/s^2 and (3,) m/s^2, from it.
        effort: (6,) or more, N m about the base's origin and N, in the world, that it
            takes to give it a_B and no angular acceleration.

    Returns:
        The flight controller's state: memory (30 + k,), thrust command (k,) N,
        acceleration (6,), reaction (3,) m/s^2 of the arm, specific thrust (1,) m/s^2,
        disturbance (6,), saturated (1,).
    """
    _, observer, integral, R_d_last, omega_d, thrust = memory_parts(x)
    quaternion, _, _, omega_W, _, _ = split_state(state)
    R = rotation_matrix(quaternion)
    omega = R.T @ omega_W
    observer = observe(loop.eso, observer, believed[3:], omega)

    reaction = effort[3:6] / loop.mass - a_B - GRAVITY * UP
    torque = R.T @ effort[:3]
    f = desired_thrust(u_v + reaction, loop.max_tilt)
    R_d = desired_attitude(f)
    rate = turn(R_d_last.T @ R_d) / loop.lag.dt
    omega_d = omega_d + loop.smoothing * (rate - omega_d)
    rate_error = omega - R.T @ (R_d @ omega_d)
    u_omega = attitude_law(loop.gains, attitude_error(R, R_d), rate_error, observer[-1])

    z_B = R[:, 2].copy()
    lift = np.array([loop.mass * np.sum(f * z_B)])
    wrench = np.concatenate((lift, loop.inertia @ u_omega + torque))
    command = allocate(loop.rotors, wrench)
    given = loop.rotors.mixer @ command
    missing = np.concatenate((u_v + reaction + GRAVITY * UP - f, wrench - given))
    saturated = not np.abs(missing).max() <= UNSATURATED
    thrust, mean = advance(loop.lag, thrust, command)
    turning = loop.rotors.mixer @ mean

    halfway = z_B + cross(omega_W, z_B) * (loop.lag.dt / 2)
    linear = halfway * (given[0] / loop.mass) - GRAVITY * UP - reaction
    angular = loop.inverse_inertia @ (turning[1:] - torque)
    integral = integral if saturated else position[9:]
    return (
        np.concatenate((position[:9], observer.ravel(), integral, R_d.ravel(), omega_d, thrust)),
        command,
        np.concatenate((linear, angular)),
        reaction,
        np.array([thrust.sum() / loop.mass]),
        np.concatenate((position[6:9] - reaction, observer[-1])),
        np.array([1.0 if saturated else 0.0]),
    )
