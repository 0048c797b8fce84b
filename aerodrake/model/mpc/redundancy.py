"""Unconstrained minimiser with the arm's null-space motion decoupled."""

import numpy as np
from scipy.linalg.lapack import dposv

from aerodrake.model.mpc.condensing import Condensing, hessian
from aerodrake.support.compiled import compiled

DEPENDENT = 1e-9
"""Relative norm of a row, after projecting out the rows before it, below which it is linearly
dependent on them."""


class DecoupledMinimiser:
    """Computes the unconstrained minimiser of a program from independent parts.

    If all joints have the same dynamics and weights, the joint coordinates can be rotated by an
    orthonormal Q whose first r columns span the row space of the task Jacobian. The remaining
    n - r null-space coordinates decouple, so H is block-diagonal: one block of 3 + r axes and
    n - r blocks of one axis each.

    Args:
        condensing: Constant part of the program.
        W_2: (m,), weights of the velocities.
    """

    def __init__(self, condensing: Condensing, W_2: np.ndarray):
        self._joints = joints = len(W_2) - 3
        kinds = condensing.kind[condensing.output_index]
        self._is_identical = all(
            bool((by_axis[3:] == by_axis[3]).all()) for by_axis in (condensing.H_input, kinds, W_2)
        )
        self._coupled = [
            condensing._replace(
                H_input=condensing.H_input[: 3 + r],
                output_index=condensing.output_index[: 3 + r],
                output_count=condensing.output_count[: 3 + r],
            )
            for r in range(joints)
        ]
        velocity = condensing.kind[condensing.output_index[3, 0]]
        self._H_velocity = condensing.products[velocity, velocity]
        self._H_input = condensing.H_input[3]

    def minimiser(
        self, C: np.ndarray, g: np.ndarray, task_jacobian: np.ndarray
    ) -> np.ndarray | None:
        """Returns z (m N,); None if joints differ, there is no null space or H is singular.

        Args:
            C: (F, F), cost of the outputs.
            g: (m N,), of the program.
            task_jacobian: (k, n), motion of all task vectors per joint motion.
        """
        if not self._is_identical:
            return None
        Q, r = task_basis(task_jacobian)
        if r == self._joints:
            return None
        C = rotated_cost(C, Q)
        N = len(self._H_input)
        descent = -g.reshape(-1, N)
        coupled = 3 + r
        rotated = Q.T @ descent[3:]
        _, task_part, info = dposv(
            hessian(self._coupled[r], C).T,
            np.concatenate([descent[:3].ravel(), rotated[:r].ravel()]),
            lower=1,
            overwrite_a=1,
            overwrite_b=1,
        )
        _, null_part, null_info = dposv(
            self._H_input + C[coupled, coupled] * self._H_velocity, rotated[r:].T
        )
        if info or null_info:
            return None
        z = np.empty_like(descent)
        z[:3] = task_part[: 3 * N].reshape(3, N)
        z[3:] = Q[:, :r] @ task_part[3 * N :].reshape(r, N) + Q[:, r:] @ null_part.T
        return z.ravel()


@compiled
def task_basis(task_jacobian: np.ndarray) -> tuple[np.ndarray, int]:
    """Returns an orthonormal Q (n, n) and r, whose first r columns span the row space.

    Args:
        task_jacobian: (k, n), of any rank r.
    """
    k, n = task_jacobian.shape
    Q, v = np.empty((n, n)), np.empty(n)
    columns = r = 0
    for i in range(k + n):
        for j in range(n):  # Rows of the Jacobian first, then unit vectors of the joints.
            v[j] = task_jacobian[i, j] if i < k else (1.0 if j == i - k else 0.0)
        norm = np.sqrt(v @ v)
        for _ in range(2):  # Repeated: one pass loses orthogonality if little is left of v.
            for j in range(columns):
                v -= (Q[j] @ v) * Q[j]
        projected = np.sqrt(v @ v)
        if projected > DEPENDENT * norm and columns < n:
            Q[columns] = v / projected
            columns += 1
        if i < k:
            r = columns
    return Q.T.copy(), r


@compiled
def rotated_cost(C: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """Returns C (F, F) in outputs whose joint coordinates are rotated by Q (n, n)."""
    n = len(Q)
    m = n + 3
    rotated = C.copy()
    for first in (3, m + 3):
        rotated[first : first + n] = Q.T @ rotated[first : first + n]
    for first in (3, m + 3):
        rotated[:, first : first + n] = np.ascontiguousarray(rotated[:, first : first + n]) @ Q
    return rotated
