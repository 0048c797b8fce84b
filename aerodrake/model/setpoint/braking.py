"""Fastest braking of setpoints."""

import numpy as np

from aerodrake.support.compiled import compiled


@compiled
def braking(v: np.ndarray, most: np.ndarray, stages_s: np.ndarray) -> np.ndarray:
    """Returns the inputs (m N,) over a horizon that brake from v and then rest, axis by axis.

    Each is divided by its limit.

    Args:
        v: (m,) m/s and rad/s, current velocities.
        most: (m,) m/s^2 and rad/s^2, limits of the accelerations.
        stages_s: (N,) s, durations of the stages.
    """
    m, N = len(v), len(stages_s)
    z = np.empty(m * N)
    for i in range(m):
        speed = v[i]
        for k in range(N):
            u = min(max(-speed / stages_s[k], -most[i]), most[i])
            speed += u * stages_s[k]
            z[i * N + k] = u / most[i]
    return z
