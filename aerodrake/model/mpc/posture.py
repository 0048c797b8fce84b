"""How base and arm share the motion, as a quadratic cost on the outputs of the stages."""

from __future__ import annotations

import numpy as np

from aerodrake.support.compiled import compiled


@compiled
def posture_cost(
    horizon: int,
    W_2: np.ndarray,
    W_4: np.ndarray,
    J_B: np.ndarray,
    offset: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """(C (F, F), c (F, N)): y' C y + 2 c_k' y is | s |^2 W_2 + | J_B (q - q_0) + offset |^2 W_4.

    Args:
        horizon: N.
        W_2: (m,), diagonal, of s = [p_B', q'].
        W_4: (3,), diagonal.
        J_B: (3, n), of the end-effector in the base frame.
        offset: (3,) m, p_EB - p_O now.
    """
    m, n = len(W_2), J_B.shape[1]
    F, first = 2 * m + 6, m + 3  # The joints' places follow the base's.
    C, c = np.zeros((F, F)), np.zeros((F, horizon))
    for a in range(m):
        C[a, a] = W_2[a]
    for i in range(3):
        for a in range(n):
            weighted = W_4[i] * J_B[i, a]
            for b in range(n):
                C[first + a, first + b] += weighted * J_B[i, b]
            c[first + a] += weighted * offset[i]
    return C, c
