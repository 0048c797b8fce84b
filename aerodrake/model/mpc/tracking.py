"""What the tool carries along a reference, as a quadratic cost on the outputs of the stages."""

from __future__ import annotations

import numpy as np

from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


@compiled
def add_tracking(
    C: np.ndarray,
    c: np.ndarray,
    value: np.ndarray,
    r: np.ndarray,
    J_c: np.ndarray,
    J_u: np.ndarray,
    rpy_rates: np.ndarray,
    reference: np.ndarray,
    gain: np.ndarray,
    weight: np.ndarray,
    tilts: bool,
    is_predicted: bool,
) -> None:
    """Adds | r_k' - r_d,k' + K (r_k - r_d,k) |^2 W of every stage k to y' C y + 2 c_k' y.

    r_k' = J_s s_k + J_yaw yaw' + J_u xi_u' with s_k = [p_B', q']; r_k moves with
    the same J_s.

    Args:
        C: (F, F), of the outputs y as `StageOutputs` has them.
        c: (F, N).
        value: (3,) what the tool carries, now: its place, or its axis' direction.
        r, J_c, J_u: As in `TaskVector`.
        rpy_rates: (3,) rad/s, roll', pitch' and yaw', held.
        reference: (N + 1, 6), r_d and r_d' now and at each stage.
        gain: (3,) 1/s, K.
        weight: (3,), diagonal of W.
        tilts: Whether the base's acceleration tilts it.
        is_predicted: Whether r_k - r_d,k is, or is held as it is now.
    """
    F, N = c.shape
    T = tilt_matrix(r) if tilts else np.zeros((3, 3))
    rows = rate_rows(J_c, T)
    if is_predicted:
        rows += gain.reshape(3, 1) * place_rows(J_c, T)
    for i in range(3):
        turning = J_u[i, 0] * rpy_rates[0] + J_u[i, 1] * rpy_rates[1] + J_c[i, 3] * rpy_rates[2]
        for f in range(F):
            weighted = weight[i] * rows[i, f]
            for g in range(F):
                C[f, g] += weighted * rows[i, g]
            for k in range(N):
                error = value[i] - reference[k + 1 if is_predicted else 0, i]
                c[f, k] += weighted * (turning - reference[k + 1, 3 + i] + gain[i] * error)


@compiled
def carried_along(
    value: np.ndarray, r: np.ndarray, J_c: np.ndarray, tilts: bool, y: np.ndarray
) -> np.ndarray:
    """(N + 1, 3), what the tool carries, now and at each stage, by its outputs y (F, N).

    Args:
        value, r, J_c, tilts: As for `add_tracking`.
    """
    rows = place_rows(J_c, tilt_matrix(r) if tilts else np.zeros((3, 3)))
    along = np.empty((y.shape[1] + 1, 3))
    along[0] = value
    for k in range(y.shape[1]):
        for i in range(3):
            moved = 0.0
            for f in range(len(y)):
                moved += rows[i, f] * y[f, k]
            along[k + 1, i] = value[i] + moved
    return along


@compiled
def place_rows(J_c: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(3, F), r per output [p_B', q', p_B, q, a, a'].

    Args:
        J_c: (3, 4 + n), of what the tool carries.
        T: (3, 3) s^2, as from `tilt_matrix`, or zero.
    """
    m = J_c.shape[1] - 1
    rows = np.zeros((3, 2 * m + 6))
    rows[:, m : m + 3], rows[:, m + 3 : 2 * m] = J_c[:, :3], J_c[:, 4:]  # Not the yaw's column.
    rows[:, 2 * m : 2 * m + 3] = T
    return rows


@compiled
def rate_rows(J_c: np.ndarray, T: np.ndarray) -> np.ndarray:
    """(3, F), r' per output, as `place_rows` has r; J_c (3, 4 + n) and T (3, 3) s^2 as there."""
    m = J_c.shape[1] - 1
    rows = np.zeros((3, 2 * m + 6))
    rows[:, :3], rows[:, 3:m] = J_c[:, :3], J_c[:, 4:]
    rows[:, 2 * m + 3 :] = T
    return rows


@compiled
def limited_gain(gain: np.ndarray, error: np.ndarray, speed: float) -> np.ndarray:
    """(3,) 1/s, the gain scaled down where it would correct `error` faster than `speed`.

    Args:
        gain: (3,) 1/s.
        error: (3,) m of a position, or 1 of a direction.
        speed: m/s, or rad/s.
    """
    correction = gain * error
    return gain * min(1.0, speed / max(np.sqrt(np.sum(correction * correction)), 1e-9))


@compiled
def tilt_matrix(r: np.ndarray) -> np.ndarray:
    """(3, 3) s^2, T: a base acceleration a tilts the base and so moves what it carries by T a.

    T = -[r]x [z]x / g, with r (3,) from the base to the end-effector in the world,
    or along its axis, for tilts small enough that the thrust stays near gravity's.
    """
    T = np.array([[-r[2], 0.0, 0.0], [0.0, -r[2], 0.0], [r[0], r[1], 0.0]])
    return T * (-1 / GRAVITY)
