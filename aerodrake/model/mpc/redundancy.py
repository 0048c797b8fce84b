"""Joints that answer alike: the arm's motions that carry the tool, apart from those that do not."""

from __future__ import annotations

import numpy as np
from scipy.linalg.lapack import dposv

from aerodrake.model.mpc.condensing import Condensing, hessian
from aerodrake.support.compiled import compiled

DEPENDENT = 1e-9
"""What is left of a row without those before it, relative to it, if they imply it."""


class Redundancy:
    """The unconstrained minimiser of a program, in parts.

    Where all joints answer and cost alike, any n orthonormal motions of the arm can be
    commanded in their place. The first r are those that carry what the cost has wishes for,
    the other n - r leave it where it is: the program has nothing to say about these but their
    own cost, and so falls apart into one of 3 + r axes and n - r of one axis each.

    Args:
        condensing: Of the program.
        W_2: (m,), cost of speeds.
    """

    def __init__(self, condensing: Condensing, W_2: np.ndarray):
        self._joints = joints = len(W_2) - 3
        answers = condensing.kind[condensing.outputs]
        self._is_alike = all(
            bool((of_axis[3:] == of_axis[3]).all())
            for of_axis in (condensing.H_input, answers, W_2)
        )
        self._coupled = [
            condensing._replace(
                H_input=condensing.H_input[: 3 + r],
                outputs=condensing.outputs[: 3 + r],
                answers=condensing.answers[: 3 + r],
            )
            for r in range(joints)
        ]
        speed = condensing.kind[condensing.outputs[3, 0]]
        self._H_speed = condensing.products[speed, speed]
        self._H_input = condensing.H_input[3]

    def minimiser(
        self, C: np.ndarray, g: np.ndarray, task_jacobian: np.ndarray
    ) -> np.ndarray | None:
        """(m N,) z; None where the joints differ, or the program does not fall apart.

        Args:
            C: (F, F), of the program.
            g: (m N,), of the program.
            task_jacobian: (k, n), how the joints move what the cost has wishes for.
        """
        if not self._is_alike:
            return None
        Q, r = motions(task_jacobian)
        if r == self._joints:
            return None
        C = turned_cost(C, Q)
        N = len(self._H_input)
        pull = -g.reshape(-1, N)
        coupled = 3 + r
        turned = Q.T @ pull[3:]
        _, along, is_bad = dposv(
            hessian(self._coupled[r], C).T,
            np.concatenate([pull[:3].ravel(), turned[:r].ravel()]),
            lower=1,
            overwrite_a=1,
            overwrite_b=1,
        )
        _, aside, is_bad_aside = dposv(
            self._H_input + C[coupled, coupled] * self._H_speed, turned[r:].T
        )
        if is_bad or is_bad_aside:
            return None
        z = np.empty_like(pull)
        z[:3] = along[: 3 * N].reshape(3, N)
        z[3:] = Q[:, :r] @ along[3 * N :].reshape(r, N) + Q[:, r:] @ aside.T
        return z.ravel()


@compiled
def motions(task_jacobian: np.ndarray) -> tuple[np.ndarray, int]:
    """(Q (n, n), r): orthonormal motions of the arm, of which the first r span the rows.

    Args:
        task_jacobian: (k, n), of any rank.
    """
    k, n = task_jacobian.shape
    Q, v = np.empty((n, n)), np.empty(n)
    found = r = 0
    for i in range(k + n):
        for j in range(n):  # The rows first, and then the joints one by one.
            v[j] = task_jacobian[i, j] if i < k else (1.0 if j == i - k else 0.0)
        whole = np.sqrt(v @ v)
        for _ in range(2):  # Once is not enough where little is left of it.
            for j in range(found):
                v -= (Q[j] @ v) * Q[j]
        left = np.sqrt(v @ v)
        if left > DEPENDENT * whole and found < n:
            Q[found] = v / left
            found += 1
        if i < k:
            r = found
    return Q.T.copy(), r


@compiled
def turned_cost(C: np.ndarray, Q: np.ndarray) -> np.ndarray:
    """(F, F), C (F, F) of outputs whose joints are turned to the motions Q (n, n)."""
    n = len(Q)
    m = n + 3
    turned = C.copy()
    for first in (3, m + 3):
        turned[first : first + n] = Q.T @ turned[first : first + n]
    for first in (3, m + 3):
        turned[:, first : first + n] = np.ascontiguousarray(turned[:, first : first + n]) @ Q
    return turned
