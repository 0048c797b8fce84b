"""Cost of posture and tracking, quadratic in the outputs of each stage."""

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


class StageCost(NamedTuple):
    """y^T C y + 2 c_k^T y, the cost of the outputs y of each stage k, as in `StageOutputs`.

    Attributes:
        C: (F, F), symmetric.
        c: (F, N).
    """

    C: np.ndarray
    c: np.ndarray


class TrackingTask(NamedTuple):
    """A task vector that follows a reference.

    Attributes:
        value: (3,), the task vector now: a position, or a direction.
        r, J_c, J_u: As in `TaskVector`.
        reference: (N + 1, 6), r_d and r_d' now and at each stage.
        gain: (3,) 1/s, K.
        weight: (3,), diagonal of W.
    """

    value: np.ndarray
    r: np.ndarray
    J_c: np.ndarray
    J_u: np.ndarray
    reference: np.ndarray
    gain: np.ndarray
    weight: np.ndarray


@compiled
def posture_cost(
    horizon: int, W_2: np.ndarray, W_4: np.ndarray, J_B: np.ndarray, offset: np.ndarray
) -> StageCost:
    """Returns the cost | s |^2 W_2 + | J_B (q - q_0) + offset |^2 W_4.

    Args:
        horizon: N.
        W_2: (m,), diagonal, for s = [p_B', q'].
        W_4: (3,), diagonal.
        J_B: (3, n), of the end-effector in the base frame.
        offset: (3,) m, p_EB - p_O now.
    """
    m, n = len(W_2), J_B.shape[1]
    F, first = 2 * m + 6, m + 3  # Joint positions follow those of the base.
    C, c = np.zeros((F, F)), np.zeros((F, horizon))
    for a in range(m):
        C[a, a] = W_2[a]
    for i in range(3):
        for a in range(n):
            weighted = W_4[i] * J_B[i, a]
            for b in range(n):
                C[first + a, first + b] += weighted * J_B[i, b]
            c[first + a] += weighted * offset[i]
    return StageCost(C, c)


@compiled
def add_tracking(
    cost: StageCost, task: TrackingTask, rpy_rates: np.ndarray, tilts: bool, is_predicted: bool
) -> None:
    """Adds | r_k' - r_d,k' + K (r_k - r_d,k) |^2 W of every stage k to a cost.

    r_k' = J_s s_k + J_yaw yaw' + J_u xi_u' with s_k = [p_B', q']; r_k changes with
    the same J_s.

    Args:
        cost: Changed in place.
        task: The task vector and its reference.
        rpy_rates: (3,) rad/s, roll', pitch' and yaw', constant over the horizon.
        tilts: True if the base's predicted acceleration tilts it (`tilt` is `flatness`).
        is_predicted: True if r_k - r_d,k is predicted, False if it is frozen at its current
            value.
    """
    F, N = cost.c.shape
    J_c, J_u, reference = task.J_c, task.J_u, task.reference
    T = tilt_matrix(task.r) if tilts else np.zeros((3, 3))
    rows = output_rows(J_c, T, is_rate=True)
    if is_predicted:
        rows += task.gain.reshape(3, 1) * output_rows(J_c, T, is_rate=False)
    for i in range(3):
        turning = J_u[i, 0] * rpy_rates[0] + J_u[i, 1] * rpy_rates[1] + J_c[i, 3] * rpy_rates[2]
        for f in range(F):
            weighted = task.weight[i] * rows[i, f]
            for g in range(F):
                cost.C[f, g] += weighted * rows[i, g]
            for k in range(N):
                error = task.value[i] - reference[k + 1 if is_predicted else 0, i]
                known = turning - reference[k + 1, 3 + i] + task.gain[i] * error
                cost.c[f, k] += weighted * known


@compiled
def predict_task(
    value: np.ndarray, r: np.ndarray, J_c: np.ndarray, tilts: bool, y: np.ndarray
) -> np.ndarray:
    """Returns the task vector (N + 1, 3) now and at each stage, from its outputs y (F, N).

    Args:
        value, r, J_c: As in `TrackingTask`.
        tilts: As for `add_tracking`.
        y: (F, N).
    """
    T = tilt_matrix(r) if tilts else np.zeros((3, 3))
    rows = output_rows(J_c, T, is_rate=False)
    predicted = np.empty((y.shape[1] + 1, 3))
    predicted[0] = value
    for k in range(y.shape[1]):
        for i in range(3):
            change = 0.0
            for f in range(len(y)):
                change += rows[i, f] * y[f, k]
            predicted[k + 1, i] = value[i] + change
    return predicted


@compiled
def output_rows(J_c: np.ndarray, T: np.ndarray, is_rate: bool) -> np.ndarray:
    """Returns (3, F): the task vector r, or its rate r', per output [p_B', q', p_B, q, a, a'].

    Args:
        J_c: (3, 4 + n), task Jacobian.
        T: (3, 3) s^2, from `tilt_matrix`, or zero.
        is_rate: True for r', False for r.
    """
    m = J_c.shape[1] - 1
    rows = np.zeros((3, 2 * m + 6))
    motion, tilt = (0, 2 * m + 3) if is_rate else (m, 2 * m)
    rows[:, motion : motion + 3] = J_c[:, :3]
    rows[:, motion + 3 : motion + m] = J_c[:, 4:]  # Without yaw's column.
    rows[:, tilt : tilt + 3] = T
    return rows


@compiled
def limited_gain(gain: np.ndarray, error: np.ndarray, speed: float) -> np.ndarray:
    """Returns the gain (3,) 1/s, scaled down if it would correct `error` faster than `speed`.

    Args:
        gain: (3,) 1/s.
        error: (3,) m of a position, or 1 of a direction.
        speed: m/s, or rad/s.
    """
    correction = gain * error
    return gain * min(1.0, speed / max(np.sqrt(np.sum(correction * correction)), 1e-9))


@compiled
def tilt_matrix(r: np.ndarray) -> np.ndarray:
    """Returns T (3, 3) s^2: a base acceleration a tilts the base, which moves r by T a.

    T = -[r]x [z]x / g, with r (3,) from the base to the end-effector in the world, or along
    its axis, for tilts so small that the thrust stays close to the weight.
    """
    T = np.array([[-r[2], 0.0, 0.0], [0.0, -r[2], 0.0], [r[0], r[1], 0.0]])
    return T * (-1 / GRAVITY)
