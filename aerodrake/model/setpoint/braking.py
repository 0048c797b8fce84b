"""Setpoints brought to rest as fast as their limits let them."""

from __future__ import annotations

import numpy as np

from aerodrake.support.compiled import compiled


@compiled
def braking(v: np.ndarray, most: np.ndarray, stages_s: np.ndarray) -> np.ndarray:
    """(m N,) inputs over their limits, axis by axis, that brake from v and then rest.

    Args:
        v: (m,) m/s and rad/s, velocities now.
        most: (m,) m/s^2 and rad/s^2, the limits of their changes.
        stages_s: (N,) s, how long each input is held.
    """
    m, N = len(v), len(stages_s)
    z = np.empty(m * N)
    for i in range(m):
        left = v[i]
        for k in range(N):
            u = min(max(-left / stages_s[k], -most[i]), most[i])
            left += u * stages_s[k]
            z[i * N + k] = u / most[i]
    return z
