"""Rotations for compiled equations, which cannot call Drake's."""

import numpy as np

from aerodrake.support.compiled import compiled

UP = np.array([0.0, 0.0, 1.0])
"""The z axis of the world."""


@compiled
def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """Returns R (3, 3) of a quaternion (4,), w first, of any length but 0."""
    w, x, y, z = quaternion
    s = 2 / (w * w + x * x + y * y + z * z)
    # Entry by entry: a list of lists would take five times as long.
    R = np.empty((3, 3))
    R[0, 0], R[1, 1] = 1 - s * (y * y + z * z), 1 - s * (x * x + z * z)
    R[2, 2] = 1 - s * (x * x + y * y)
    R[0, 1], R[1, 0] = s * (x * y - w * z), s * (x * y + w * z)
    R[0, 2], R[2, 0] = s * (x * z + w * y), s * (x * z - w * y)
    R[1, 2], R[2, 1] = s * (y * z - w * x), s * (y * z + w * x)
    return R


@compiled
def roll_pitch_yaw(R: np.ndarray) -> np.ndarray:
    """Returns roll, pitch and yaw (3,) rad of R = R_z R_y R_x (3, 3), pitch within +- 90 deg."""
    level = np.sqrt(R[2, 1] * R[2, 1] + R[2, 2] * R[2, 2])
    return np.array(
        [np.arctan2(R[2, 1], R[2, 2]), np.arctan2(-R[2, 0], level), np.arctan2(R[1, 0], R[0, 0])]
    )


@compiled
def rpy_rates(R: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Returns the rates (3,) rad/s of roll, pitch and yaw.

    Args:
        R: (3, 3), rotation matrix.
        omega: (3,) rad/s, in the frame that R maps to; pitch must be within +- 90 deg.
    """
    # Components along the level axis ahead and the one to its left, the axis of pitch.
    level = np.sqrt(R[0, 0] * R[0, 0] + R[1, 0] * R[1, 0])
    ahead_x, ahead_y = R[0, 0] / level, R[1, 0] / level
    ahead = ahead_x * omega[0] + ahead_y * omega[1]
    pitch_rate = ahead_x * omega[1] - ahead_y * omega[0]
    return np.array([ahead / level, pitch_rate, omega[2] - R[2, 0] / level * ahead])


@compiled
def quaternion_of(rpy: np.ndarray) -> np.ndarray:
    """Returns the quaternion (4,) of rpy (3,) rad, roll, pitch and yaw: R = R_z R_y R_x."""
    c, s = np.cos(rpy / 2), np.sin(rpy / 2)
    return np.array(
        [
            c[0] * c[1] * c[2] + s[0] * s[1] * s[2],
            s[0] * c[1] * c[2] - c[0] * s[1] * s[2],
            c[0] * s[1] * c[2] + s[0] * c[1] * s[2],
            c[0] * c[1] * s[2] - s[0] * s[1] * c[2],
        ]
    )


@compiled
def conjugate(quaternion: np.ndarray) -> np.ndarray:
    """Returns the inverse (4,) of a unit quaternion (4,)."""
    w, x, y, z = quaternion
    return np.array([w, -x, -y, -z])


@compiled
def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns the quaternion (4,) of the rotation b (4,) followed by the rotation a (4,)."""
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
    """Returns the unit quaternion (4,) after a rotation by `vector` (3,) rad in its own frame."""
    angle = length(vector)
    # sin(angle / 2) / angle, whose limit at 0 is 1 / 2.
    factor = np.sin(angle / 2) / angle if angle > 1e-12 else 0.5
    by = np.array([np.cos(angle / 2), factor * vector[0], factor * vector[1], factor * vector[2]])
    rotated = product(quaternion, by)
    return rotated / length(rotated)


@compiled
def rotation_vector(quaternion: np.ndarray) -> np.ndarray:
    """Returns the rotation vector (3,) rad, at most pi long, of a quaternion (4,) not 0."""
    sign = 1.0 if quaternion[0] >= 0 else -1.0
    v = sign * quaternion[1:]
    sine = length(v)
    if sine < 1e-12 * abs(quaternion[0]):
        return 2 * v / abs(quaternion[0])
    return v * (2 * np.arctan2(sine, abs(quaternion[0])) / sine)


@compiled
def vee(R: np.ndarray) -> np.ndarray:
    """Returns the vector (3,) of (R - R^T) / 2: the axis of R (3, 3) times sin(angle)."""
    return 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])


@compiled
def turn(R: np.ndarray) -> np.ndarray:
    """Returns the rotation vector (3,) rad, shorter than pi, of a rotation matrix R (3, 3)."""
    v = vee(R)
    sine = np.sqrt(np.sum(v * v))
    if sine == 0:
        return v
    return v * (np.arctan2(sine, (R[0, 0] + R[1, 1] + R[2, 2] - 1) / 2) / sine)


@compiled
def apply(R: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Returns R v (3,) of R (3, 3) and v (3,); at this size R @ v is slower."""
    return np.array(
        [
            R[0, 0] * v[0] + R[0, 1] * v[1] + R[0, 2] * v[2],
            R[1, 0] * v[0] + R[1, 1] * v[1] + R[1, 2] * v[2],
            R[2, 0] * v[0] + R[2, 1] * v[1] + R[2, 2] * v[2],
        ]
    )


@compiled
def length(v: np.ndarray) -> float:
    """Returns the Euclidean norm of v (m,)."""
    total = 0.0
    for x in v:
        total += x * x
    return np.sqrt(total)


@compiled
def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Returns a x b (3,) of a (3,) and b (3,)."""
    return np.array(
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    )
