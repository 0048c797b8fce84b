"""Discrete PID controller of the arm's joints."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.low_level.torque_limits import compensation, within_limits
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Arm
from aerodrake.support.arguments import Period, checked
from aerodrake.support.compiled import compiled


class JointPid(NamedTuple):
    """Gains and limits of torque = M (k_p e + k_d e') + D q_r' + integral, without windup.

    The inertia M decouples the joints, so that their poles do not depend on the arm. The first two
    terms are accelerations: k_d times the error between the joint's rate and the reference rate
    q_r' = q_d' + e k_p / k_d. As in a cascade, the reference rate is limited: by the joint's
    velocity limit, and by k_p / k_d times the distance to its stop. Hence no position error drives
    a joint faster than its limit or into a stop. The viscous torque D is that of the reference
    rate, as in J.-J. Slotine and W. Li, "On the adaptive control of robot manipulators", 1987: with
    the measured rate, an overestimated D would be unstable.

    Attributes:
        inertia: (n, n) kg m^2, M; diagonal for independent PIDs.
        damping: (n,) N m s/rad, D.
        k_p: 1/s^2.
        k_d: 1/s.
        k_i: 1/s^3.
        effort: (n,) N m, torque limits.
        velocity: (n,) rad/s, velocity limits.
        lower, upper: (n,) rad, stops.
        dt: s, period.
    """

    inertia: np.ndarray
    damping: np.ndarray
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
        """Returns the PID with bandwidth and damping ratio of `arm`; dt in s.

        Its inertia is that in the working configuration. The independent PIDs of `arm.inertia`
        diagonal do not compensate the joints' damping, as in the paper.
        """
        inertia, damping = np.ascontiguousarray(vehicle.arm_inertia), vehicle.joint_damping
        if arm.inertia == "diagonal":
            inertia, damping = np.diag(np.diag(inertia)), np.zeros(vehicle.joints)
        k_p = arm.bandwidth_rad_s**2
        k_d = 2 * arm.damping * arm.bandwidth_rad_s
        k_i = k_p * arm.integral_rad_s
        limits = vehicle.effort, vehicle.velocity, vehicle.lower, vehicle.upper
        return cls(inertia, damping, k_p, k_d, k_i, *limits, dt)


@compiled
def control(
    pid: JointPid, state: np.ndarray, setpoint: np.ndarray, integral: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the torques, and the integral one period later.

    The integral is that of k_i (M + D / k_d) times the position error or, while the reference rate
    is limited, the error of the rate over k_p / k_d: it is as fast for any M and D. A joint whose
    torque is at its limit, and whose error drives it further, does not integrate; its integral
    would displace the other joints through M. The integral neither drives a torque beyond its
    limit, nor exceeds that limit by itself.

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
    error, stiffness = setpoint[:n] - q, pid.k_p / pid.k_d
    rate, drive = setpoint[n : 2 * n] + stiffness * error, error.copy()
    for i in range(n):
        highest = min(pid.velocity[i], stiffness * (pid.upper[i] - q[i]))
        lowest = max(-pid.velocity[i], stiffness * (pid.lower[i] - q[i]))
        limited = min(max(rate[i], lowest), highest)
        if limited != rate[i]:
            rate[i], drive[i] = limited, (limited - qdot[i]) / stiffness
    desired = pid.inertia @ (pid.k_d * (rate - qdot)) + pid.damping * rate + integral
    torque = within_limits(pid.inertia, desired, pid.effort)
    is_winding = (np.abs(torque) >= pid.effort) & (torque * drive > 0)
    drive = np.where(is_winding, 0.0, drive)
    step = pid.k_i * pid.dt * (pid.inertia @ drive + pid.damping / pid.k_d * drive)
    step += compensation(pid.inertia, is_winding, -step)
    step = np.minimum(np.maximum(step, -pid.effort - torque), pid.effort - torque)
    new_integral = integral + np.where(is_winding, 0.0, step)
    return torque, np.minimum(np.maximum(new_integral, -pid.effort), pid.effort)
