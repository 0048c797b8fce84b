"""Rotations inside compiled equations, where Drake's cannot be called; tested against these."""

from __future__ import annotations

import numpy as np

from aerodrake.compiled import compiled


@compiled
def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """(3, 3), of a quaternion (4,), w first, of any length but 0."""
    w, x, y, z = quaternion / np.sqrt(np.sum(quaternion * quaternion))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


@compiled
def roll_pitch_yaw(R: np.ndarray) -> np.ndarray:
    """(3,) rad of a rotation matrix (3, 3), pitch within +- 90 deg: R = R_z R_y R_x."""
    level = np.sqrt(R[2, 1] * R[2, 1] + R[2, 2] * R[2, 2])
    return np.array(
        [
            np.arctan2(R[2, 1], R[2, 2]),
            np.arctan2(-R[2, 0], level),
            np.arctan2(R[1, 0], R[0, 0]),
        ]
    )


@compiled
def rpy_rates(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """(3,) rad/s, how fast roll, pitch and yaw of R (3, 3) change at omega (3,) rad/s.

    Args:
        omega: In the frame that R leads to; pitch is to be within +- 90 deg.
    """
    # Along the level axis ahead, and the one to its left, about which pitch turns.
    level = np.sqrt(R[0, 0] * R[0, 0] + R[1, 0] * R[1, 0])
    ahead_x, ahead_y = R[0, 0] / level, R[1, 0] / level
    ahead = ahead_x * omega[0] + ahead_y * omega[1]
    pitch_rate = ahead_x * omega[1] - ahead_y * omega[0]
    return np.array([ahead / level, pitch_rate, omega[2] - R[2, 0] / level * ahead])


@compiled
def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(4,) the quaternion of the rotation b (4,), followed by a (4,)."""
    return np.array(
        [
            a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
            a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
            a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
            a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
        ]
    )


@compiled
def turned(quaternion: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """(4,) of length 1: the attitude turned by a rotation vector (3,) rad in its own frame."""
    angle = np.sqrt(np.sum(vector * vector))
    # sin(angle / 2) / angle, which is 1 / 2 where they vanish.
    factor = np.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    by = np.array([np.cos(angle / 2), factor * vector[0], factor * vector[1], factor * vector[2]])
    found = product(quaternion, by)
    return found / np.sqrt(np.sum(found * found))


@compiled
def rotation_vector(quaternion: np.ndarray) -> np.ndarray:
    """(3,) rad, at most half a turn, of a quaternion (4,) of any length but 0."""
    sign = 1.0 if quaternion[0] >= 0 else -1.0
    v = sign * quaternion[1:]
    sine = np.sqrt(np.sum(v * v))
    if sine < 1e-12 * abs(quaternion[0]):
        return 2 * v / abs(quaternion[0])
    return v * (2 * np.arctan2(sine, abs(quaternion[0])) / sine)


@compiled
def vee(R: np.ndarray) -> np.ndarray:
    """(3,) of the skew part (R - R') / 2; of a rotation, its axis times the sine of its angle."""
    return 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


@compiled
def turn(R: np.ndarray) -> np.ndarray:
    """(3,) rad, the rotation vector of a rotation matrix (3, 3) of less than half a turn."""
    v = vee(R)
    sine = np.sqrt(np.sum(v * v))
    if sine == 0:
        return v
    return v * (np.arctan2(sine, (R[0, 0] + R[1, 1] + R[2, 2] - 1) / 2) / sine)


@compiled
def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(3,) a x b."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
