"""Setpoint motions for data collection: curves in slowly turning planes."""

import math

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.model.reference.reference_curve import Motion
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel

CORRECTION = 2.0
"""1/s, gain of the joints' correction of the tool's path error."""

CENTERING = 0.5
"""1/s, gain of the null-space motion towards the working configuration."""


def turn_about(centre: np.ndarray, motion: Motion, times: np.ndarray, turn_s: float) -> Motion:
    """Returns a motion whose frame turns about the vertical through `centre`.

    Args:
        centre: (3,) m.
        motion: Motion in the turning frame.
        times: (T,) s; negative before the frame begins to turn.
        turn_s: s, time of one turn.
    """
    p, v = motion
    rate = 2 * math.pi / turn_s
    angle = rate * np.maximum(times, 0.0)
    cos, sin, zero, one = np.cos(angle), np.sin(angle), 0 * angle, 0 * angle + 1
    R = np.stack([cos, -sin, zero, sin, cos, zero, zero, zero, one], axis=-1).reshape(-1, 3, 3)
    offset = np.einsum("tij,tj->ti", R, p - centre)
    swept = rate * np.cross([0.0, 0.0, 1.0], offset) * (times >= 0)[:, None]
    return centre + offset, np.einsum("tij,tj->ti", R, v) + swept


def joint_motion(path: Motion, vehicle: VehicleModel, period: float) -> PiecewisePolynomial:
    """Returns q_d, (n,) rad over time, that follows a tool path in the base frame.

    Among the joint velocities that follow the path, those nearest to a return to the working
    configuration are used (Siciliano et al., Robotics, 2009, section 3.5.1), so that the
    null-space motion does not drift. The weight of a joint is the inverse of its distance to
    the nearer limit in the working configuration, where the motion starts.

    Args:
        path: (T, 3) m and (T, 3) m/s at the times 0, period, ..., from p_O at rest.
        vehicle: The vehicle with the arm.
        period: s.

    Raises:
        ValueError: if the motion exceeds the joints' limits.
    """
    kinematics = Kinematics(vehicle.plant)
    margin = np.minimum(vehicle.upper - vehicle.working, vehicle.working - vehicle.lower)
    scale = np.sqrt(margin)
    q, qdot = vehicle.working, np.zeros(vehicle.joints)
    velocities = [qdot]
    for p, v in zip(path[0][:-1], path[1][1:], strict=True):
        p_EB, J_B = kinematics.arm(q)
        centering = CENTERING * (vehicle.working - q)
        missing = v + CORRECTION * (p - p_EB) - J_B @ centering
        next_qdot = centering + scale * (np.linalg.pinv(J_B * scale) @ missing)
        q = q + (qdot + next_qdot) * (period / 2)
        qdot = next_qdot
        velocities.append(qdot)
    velocity = np.array(velocities)
    motion = held_acceleration_motion(vehicle.working, velocity, period)
    position = motion.vector_values(period * np.arange(len(velocity))).T
    acceleration = np.diff(velocity, axis=0) / period
    if (
        (position < vehicle.lower).any()
        or (position > vehicle.upper).any()
        or (np.abs(velocity) > vehicle.velocity).any()
        or (np.abs(acceleration) > vehicle.acceleration).any()
    ):
        raise ValueError("the joints' limits do not allow the tool's path")
    return motion
