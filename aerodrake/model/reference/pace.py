"""How a curve is set out upon."""

from __future__ import annotations

import numpy as np

from aerodrake.support.compiled import compiled


@compiled
def smooth_start(times: np.ndarray, start_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Time along a curve whose pace rises from 0 to 1 in `start_s`.

    The pace is the smoothstep 3 x^2 - 2 x^3 of x = t / start_s, whose slope
    vanishes at both ends: acceleration is continuous.

    Args:
        times: (T,) s, >= 0.
        start_s: s, > 0.

    Returns:
        (T,) s, time along the curve, t - start_s / 2 after the start; and (T,), the pace.
    """
    x = np.minimum(times / start_s, 1.0)
    s = start_s * (x**3 - x**4 / 2) + np.maximum(times - start_s, 0.0)
    return s, x**2 * (3 - 2 * x)
