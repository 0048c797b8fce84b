"""Extended state observer of an integrator chain with an unknown constant input."""

from __future__ import annotations

import math

import numpy as np


class ExtendedStateObserver:
    """Estimates the states of y^(m) = u + h, per axis, and the disturbance h.

    Cao et al. 2023 have it in continuous time with all poles at -w; this is
    its exact discretisation, with all poles at exp(-w dt), so that it stays
    well damped at any rate.

    Args:
        order: m, 1 for a velocity that is measured, 2 for a position.
        bandwidth: w, rad/s.
        dt: s, sampling period.
    """

    def __init__(self, order: int, bandwidth: float, dt: float):
        beta = math.exp(-bandwidth * dt)
        if order == 1:
            self.A = np.array([[1, dt], [0, 1]])
            self.B = np.array([dt, 0])
            self.L = np.array([1 - beta**2, (1 - beta) ** 2 / dt])
        elif order == 2:
            self.A = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
            self.B = np.array([dt**2 / 2, dt, 0])
            self.L = np.array(
                [
                    1 - beta**3,
                    1.5 * (1 - beta) ** 2 * (1 + beta) / dt,
                    (1 - beta) ** 3 / dt**2,
                ]
            )
        else:
            raise ValueError(f"order must be 1 or 2, got {order}")

    def step(self, x: np.ndarray, u: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The estimate at the present sample.

        Args:
            x: (m + 1, axes), the estimate at the sample before: [y, ..., h].
            u: (axes,), the known input since then.
            y: (axes,), what is measured now.
        """
        predicted = self.A @ x + np.outer(self.B, u)
        return predicted + np.outer(self.L, y - predicted[0])
