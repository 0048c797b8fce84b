"""The two loops of the base's low-level controller, one sample of each."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.compiled import compiled
from aerodrake.model.eso import ExtendedStateObserver, observe
from aerodrake.model.flight_law import (
    UP,
    AttitudeGains,
    PositionGains,
    attitude_error,
    attitude_law,
    desired_attitude,
    desired_thrust,
    position_law,
)
from aerodrake.model.rotation import cross, rotation_matrix, turn
from aerodrake.model.rotor_lag import RotorLag, advance
from aerodrake.model.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle import GRAVITY, Vehicle
from aerodrake.model.vehicle_state import parts
from aerodrake.scenario import Flight, Rotor

UNSATURATED = 1e-6
"""m/s^2, N or N m: what a command may miss by rounding."""


class OuterLoop(NamedTuple):
    """From a base setpoint to the acceleration wanted.

    Attributes:
        gains: Of the position law.
        eso: The position observer.
        is_trajectory: Whether v_d and a_d are heeded, not p_d alone.
        max_tilt: rad.
        most_thrust: m/s^2, of all rotors over mass.
        dt: s, period.
    """

    gains: PositionGains
    eso: ExtendedStateObserver
    is_trajectory: bool
    max_tilt: float
    most_thrust: float
    dt: float

    @classmethod
    def make(cls, config: Flight, rotor: Rotor, vehicle: Vehicle, period: float) -> OuterLoop:
        """Of the scenario's gains and this vehicle."""
        return cls(
            gains=PositionGains.make(config),
            eso=ExtendedStateObserver.make(2, config.position_eso_rad_s, period),
            is_trajectory=config.interface == "trajectory",
            max_tilt=config.max_tilt_rad,
            most_thrust=len(vehicle.rotors.names) * rotor.max_thrust_n / vehicle.mass,
            dt=period,
        )


class InnerLoop(NamedTuple):
    """From the acceleration wanted to rotor thrusts.

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
    def make(cls, config: Flight, rotor: Rotor, vehicle: Vehicle, period: float) -> InnerLoop:
        """Of the scenario's gains and this vehicle.

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


def initial_memory(p_B: np.ndarray, h_omega: np.ndarray, thrust: np.ndarray) -> np.ndarray:
    """(30 + k,), what the loops remember at rest and level at p_B.

    [position observer (9), attitude observer (6), integral (3) of the position
    error, R_d (9), the last desired attitude, omega_d (3) rad/s, its filtered
    rate, in its own frame, thrust (k) N that the rotors are believed to give].

    Args:
        p_B: (3,) m.
        h_omega: (3,) rad/s^2, what the attitude observer knows already.
        thrust: (k,) N.
    """
    position, attitude = np.concatenate([p_B, np.zeros(6)]), np.concatenate([np.zeros(3), h_omega])
    rest = np.zeros(3)
    return np.concatenate([position, attitude, rest, np.eye(3).ravel(), rest, thrust])


@compiled
def memory_parts(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """The parts of a memory (30 + k,), as `initial_memory` has them, in their shapes; views."""
    return (
        x[:9].reshape(3, 3),
        x[9:15].reshape(2, 3),
        x[15:18],
        x[18:27].reshape(3, 3),
        x[27:30],
        x[30:],
    )


@compiled
def outer_loop(
    loop: OuterLoop, x: np.ndarray, believed: np.ndarray, state: np.ndarray, setpoint: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Position observer and position law.

    Args:
        loop: Constants.
        x: (30 + k,) memory.
        believed: (6,) acceleration since the last sample, without disturbances, linear
            and angular; m/s^2 in the world and rad/s^2 in the base frame.
        state: (13 + 2 n,) measured.
        setpoint: (9,) p_d, v_d, a_d in m, m/s, m/s^2.

    Returns:
        (12,) position observer now, and integral if nothing saturates; u_v (3,)
        m/s^2, wanted; a_B (3,) m/s^2, as much of it as tilt and thrust allow.
    """
    observer, _, integral, _, _, _ = memory_parts(x)
    _, p_B, _, _, v_B, _ = parts(state)
    p_d, v_d, a_d = setpoint[:3], setpoint[3:6], setpoint[6:]
    if not loop.is_trajectory:
        v_d = a_d = np.zeros(3)
    observer = observe(loop.eso, observer, believed[:3], p_B)
    error = p_B - p_d
    u_v = position_law(loop.gains, error, v_B - v_d, a_d, observer[-1], integral)
    thrust = desired_thrust(u_v, loop.max_tilt)
    share = min(1.0, loop.most_thrust / np.sqrt(np.sum(thrust * thrust)))
    position = np.concatenate((observer.ravel(), integral + loop.dt * error))
    return position, u_v, share * thrust - GRAVITY * UP


@compiled
def commanded_motion(
    state: np.ndarray, joint_setpoint: np.ndarray, a_B: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The state (13 + 2 n,) with the arm as commanded, and v' (6 + n,) with no turn of the base.

    The commanded arm, since the measured one is noisier than its lag is long.

    Args:
        state: (13 + 2 n,) measured.
        joint_setpoint: (3 n,) q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        a_B: (3,) m/s^2, of the base's origin in the world.
    """
    n = len(joint_setpoint) // 3
    q_d, qdot_d, qddot_d = joint_setpoint[:n], joint_setpoint[n : 2 * n], joint_setpoint[2 * n :]
    quaternion, p_B, _, omega_W, v_B, _ = parts(state)
    x = np.concatenate((quaternion, p_B, q_d, omega_W, v_B, qdot_d))
    return x, np.concatenate((np.zeros(3), a_B, qddot_d))


@compiled
def rigid_body_effort(
    mass: float, inertia: np.ndarray, state: np.ndarray, a_B: np.ndarray
) -> np.ndarray:
    """(6,) what `WholeBody.effort` says of the base, for a rigid body with its mass at the origin.

    Args:
        mass: kg.
        inertia: (3, 3) kg m^2 in the base frame.
        state: (13 + 2 n,) measured.
        a_B: (3,) m/s^2, of the base's origin in the world.
    """
    quaternion, _, _, omega_W, _, _ = parts(state)
    R = rotation_matrix(quaternion)
    omega = R.T @ omega_W
    torque = cross(omega, inertia @ omega)
    return np.concatenate((R @ torque, mass * (a_B + GRAVITY * UP)))


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
        loop: Constants.
        x, believed, state: As `outer_loop` has them.
        position, u_v, a_B: From it.
        effort: (6,) or more, N m about the base's origin and N, in the world, that it
            takes to give it a_B and no angular acceleration.

    Returns:
        The flight controller's state: memory (30 + k,), thrust command (k,) N,
        acceleration (6,), reaction (3,) m/s^2 of the arm, specific thrust (1,) m/s^2,
        disturbance (6,), saturated (1,).
    """
    _, observer, integral, R_d_last, omega_d, thrust = memory_parts(x)
    quaternion, _, _, omega_W, _, _ = parts(state)
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
