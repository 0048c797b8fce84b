"""Discrete PID controller of the arm's joints."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Arm
from aerodrake.support.arguments import Period, checked
from aerodrake.support.compiled import compiled


class JointPid(NamedTuple):
    """Gains and limits of torque = k_p e + k_d e' + integral, without windup.

    The first two terms are k_d times the error between the joint's rate and the desired rate
    q_d' + e k_p / k_d. As in a cascade, the desired rate is limited: by the joint's velocity
    limit, and by k_p / k_d times the distance to its stop. Hence no position error drives a
    joint faster than its limit or into a stop.

    Attributes:
        k_p: (n,) N m/rad.
        k_d: (n,) N m s/rad.
        k_i: (n,) N m/(rad s).
        effort: (n,) N m, torque limits.
        velocity: (n,) rad/s, velocity limits.
        lower, upper: (n,) rad, stops.
        dt: s, period.
    """

    k_p: np.ndarray
    k_d: np.ndarray
    k_i: np.ndarray
    effort: np.ndarray
    velocity: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    dt: float

    @classmethod
    @checked
    def make(cls, arm: Arm, vehicle: VehicleModel, dt: Period) -> Self:
        """Returns gains that give each joint the bandwidth and damping of `arm`; dt in s."""
        k_p = vehicle.joint_inertia * arm.bandwidth_rad_s**2
        k_d = vehicle.joint_inertia * 2 * arm.damping * arm.bandwidth_rad_s
        k_i = k_p * arm.integral_rad_s
        limits = vehicle.effort, vehicle.velocity, vehicle.lower, vehicle.upper
        return cls(k_p, k_d, k_i, *limits, dt)


@compiled
def control(
    pid: JointPid, state: np.ndarray, setpoint: np.ndarray, integral: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the torques, and the integral one period later.

    The integral is that of the position error or, while the desired rate is limited, of the
    error of the rate over k_p / k_d. It is constant while the torque is at its limit and the
    error would drive it further. By itself it never exceeds the torque limit.

    Args:
        pid: Gains and limits.
        state: (13 + 2 n,) measured, as `VehicleState` has it.
        setpoint: (3 n,) q_d, q_d', q_d''; q_d'' is ignored.
        integral: (n,) N m.

    Returns:
        (n,) N m each.
    """
    _, _, q, _, _, qdot = split_state(state)
    n = len(q)
    torque, new_integral = np.empty(n), np.empty(n)
    for i in range(n):
        error, rate_error = setpoint[i] - q[i], setpoint[n + i] - qdot[i]
        stiffness = pid.k_p[i] / pid.k_d[i]
        rate = setpoint[n + i] + stiffness * error
        highest = min(pid.velocity[i], stiffness * (pid.upper[i] - q[i]))
        lowest = max(-pid.velocity[i], stiffness * (pid.lower[i] - q[i]))
        excess = rate - min(max(rate, lowest), highest)
        desired = pid.k_p[i] * error + pid.k_d[i] * (rate_error - excess) + integral[i]
        torque[i] = _clipped(desired, pid.effort[i])
        drive = error if excess == 0 else error + (rate_error - excess) / stiffness
        is_winding = abs(desired) > pid.effort[i] and desired * drive > 0
        step = 0.0 if is_winding else pid.k_i[i] * drive * pid.dt
        new_integral[i] = _clipped(integral[i] + step, pid.effort[i])
    return torque, new_integral


@compiled
def _clipped(value: float, limit: float) -> float:
    return np.minimum(np.maximum(value, -limit), limit)
