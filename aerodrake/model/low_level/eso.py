"""Extended state observer (ESO) of an integrator chain with an unknown constant input.

The `FlightController` has two: for position (`outer_loop`) and angular velocity (`inner_loop`).
"""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.support.compiled import compiled


class ExtendedStateObserver(NamedTuple):
    """Estimates the states of y^(m) = u + h, per axis, and the disturbance h.

    Cao et al. 2023 give the observer in continuous time, with all poles at -w. This is
    its exact discretisation, with all poles at exp(-w dt), which is well damped at any
    rate.

    Attributes:
        A: (m + 1, m + 1), state transition over a period.
        B: (m + 1, 1), effect of the input u over a period.
        L: (m + 1, 1), gain of the innovation.
    """

    A: np.ndarray
    B: np.ndarray
    L: np.ndarray

    @classmethod
    def make(cls, order: int, bandwidth: float, dt: float) -> Self:
        """Returns the observer for a measured velocity (order 1) or position (order 2).

        Args:
            order: m.
            bandwidth: w, rad/s.
            dt: s, sampling period.
        """
        beta = math.exp(-bandwidth * dt)
        gap = 1 - beta
        if order == 1:
            A, B = [[1, dt], [0, 1]], [dt, 0]
            L = [1 - beta**2, gap**2 / dt]
        elif order == 2:
            A, B = [[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]], [dt**2 / 2, dt, 0]
            L = [1 - beta**3, 1.5 * gap**2 * (1 + beta) / dt, gap**3 / dt**2]
        else:
            raise ValueError(f"order must be 1 or 2, got {order}")
        return cls(np.array(A), np.array(B)[:, np.newaxis], np.array(L)[:, np.newaxis])


@compiled
def observe(eso: ExtendedStateObserver, x: np.ndarray, u: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Returns the new estimate (m + 1, axes): x+ = A x + B u, plus L (y - first row of x+).

    Args:
        eso: The observer.
        x: (m + 1, axes), estimate at the previous sample: [y, ..., h].
        u: (axes,), known input since then.
        y: (axes,), measured now.
    """
    predicted = eso.A @ x + eso.B * u
    return predicted + eso.L * (y - predicted[0])
