"""Motions of the setpoints while data is collected: curves in planes that turn slowly."""

from __future__ import annotations

import math

import numpy as np
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.model.reference.reference_curve import Motion
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel

CORRECTION = 2.0
"""1/s, with which the joints take out the tool's distance from its path."""

CENTERING = 0.5
"""1/s, with which motion that leaves the tool in place returns to the working configuration."""


def turn_about(centre: np.ndarray, motion: Motion, times: np.ndarray, turn_s: float) -> Motion:
    """The motion as it is when its frame turns about the vertical through `centre`.

    Args:
        centre: (3,) m.
        motion: In the frame that turns.
        times: (T,) s; negative before the frame begins to turn.
        turn_s: s, in which it turns once.
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
    """q_d from the working configuration with which the tool follows a path in the base frame.

    Of all joint velocities that move the tool as asked, those nearest to a
    return to the working configuration (Siciliano et al., Robotics, 2009,
    section 3.5.1), so that the arm's redundant motion does not drift. A joint
    counts by the inverse of the room that it has there to its nearer limit.

    Args:
        path: (T, 3) m and (T, 3) m/s at the times 0, period, ..., from p_O at rest.
        vehicle: Whose arm it is.
        period: s.

    Returns:
        (n,) rad over [0, (T - 1) period].

    Raises:
        ValueError: if that asks for more than the joints' limits.
    """
    kinematics = Kinematics(vehicle.plant)
    room = np.minimum(vehicle.upper - vehicle.working, vehicle.working - vehicle.lower)
    scale = np.sqrt(room)
    q, qdot = vehicle.working, np.zeros(vehicle.joints)
    velocities = [qdot]
    for p, v in zip(path[0][:-1], path[1][1:], strict=True):
        p_EB, J_B = kinematics.arm(q)
        centering = CENTERING * (vehicle.working - q)
        asked = v + CORRECTION * (p - p_EB)
        missing = asked - J_B @ centering
        following = centering + scale * (np.linalg.pinv(J_B * scale) @ missing)
        q = q + (qdot + following) * (period / 2)
        qdot = following
        velocities.append(qdot)
    motion = held_acceleration_motion(vehicle.working, np.array(velocities), period)
    _check_limits(motion, np.array(velocities), vehicle, period)
    return motion


def _check_limits(
    motion: PiecewisePolynomial, velocity: np.ndarray, vehicle: VehicleModel, period: float
) -> None:
    position = motion.vector_values(period * np.arange(len(velocity))).T
    acceleration = np.diff(velocity, axis=0) / period
    if (
        (position < vehicle.lower).any()
        or (position > vehicle.upper).any()
        or (np.abs(velocity) > vehicle.velocity).any()
        or (np.abs(acceleration) > vehicle.acceleration).any()
    ):
        raise ValueError("the joints' limits do not let the tool follow its path")
