"""Discrete PID controller of the arm's joints."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Arm
from aerodrake.support.arguments import Period, checked
from aerodrake.support.compiled import compiled


class JointPid(NamedTuple):
    """Gains and limits of torque = M (k_p e + k_d e') + integral, without windup.

    The inertia M decouples the joints. The first two terms are k_d times the error between the
    joint's rate and the desired rate q_d' + e k_p / k_d. As in a cascade, the desired rate is
    limited: by the joint's velocity limit, and by k_p / k_d times the distance to its stop. Hence
    no position error drives a joint faster than its limit or into a stop.

    Attributes:
        inertia: (n, n) kg m^2, M.
        k_p: 1/s^2.
        k_d: 1/s.
        k_i: 1/s^3.
        effort: (n,) N m, torque limits.
        velocity: (n,) rad/s, velocity limits.
        lower, upper: (n,) rad, stops.
        dt: s, period.
    """

    inertia: np.ndarray
    k_p: float
    k_d: float
    k_i: float
    effort: np.ndarray
    velocity: np.ndarray
    lower: np.ndarray
    upper: np.ndarray
    dt: float

    @classmethod
    @checked
    def make(cls, arm: Arm, vehicle: VehicleModel, dt: Period) -> Self:
        """Returns gains that give each joint the bandwidth and damping of `arm`; dt in s."""
        inertia = np.ascontiguousarray(vehicle.arm_inertia)
        if arm.inertia == "diagonal":
            inertia = np.diag(np.diag(inertia))
        k_p = arm.bandwidth_rad_s**2
        k_d = 2 * arm.damping * arm.bandwidth_rad_s
        limits = vehicle.effort, vehicle.velocity, vehicle.lower, vehicle.upper
        return cls(inertia, k_p, k_d, k_p * arm.integral_rad_s, *limits, dt)


@compiled
def control(
    pid: JointPid, state: np.ndarray, setpoint: np.ndarray, integral: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the torques, and the integral one period later.

    The integral is that of the position error or, while the desired rate is limited, of the
    error of the rate over k_p / k_d. It neither drives the torque beyond its limit, nor exceeds
    that limit by itself.

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
    acceleration, drive = np.empty(n), np.empty(n)
    stiffness = pid.k_p / pid.k_d
    for i in range(n):
        error, rate_error = setpoint[i] - q[i], setpoint[n + i] - qdot[i]
        rate = setpoint[n + i] + stiffness * error
        highest = min(pid.velocity[i], stiffness * (pid.upper[i] - q[i]))
        lowest = max(-pid.velocity[i], stiffness * (pid.lower[i] - q[i]))
        excess = rate - min(max(rate, lowest), highest)
        acceleration[i] = pid.k_p * error + pid.k_d * (rate_error - excess)
        drive[i] = error if excess == 0 else error + (rate_error - excess) / stiffness
    desired = pid.inertia @ acceleration + integral
    step = pid.k_i * pid.dt * (pid.inertia @ drive)
    torque, new_integral = np.empty(n), np.empty(n)
    for i in range(n):
        torque[i] = _clipped(desired[i], pid.effort[i])
        room = max(pid.effort[i] - desired[i], 0.0), max(pid.effort[i] + desired[i], 0.0)
        winding = min(max(step[i], -room[1]), room[0])
        new_integral[i] = _clipped(integral[i] + winding, pid.effort[i])
    return torque, new_integral


@compiled
def _clipped(value: float, limit: float) -> float:
    return np.minimum(np.maximum(value, -limit), limit)
