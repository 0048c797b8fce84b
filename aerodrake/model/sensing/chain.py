"""Gains of the steady-state Kalman filter for a value, its rate and a disturbance."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_are

CONVERGED = 1e-12
"""Relative change of the covariance over a cycle at which the Riccati recursion ends."""

MOST_CYCLES = 10_000
"""Largest number of cycles of the Riccati recursion."""


class Chain(NamedTuple):
    """Chain x' = rate, rate' = a + d, d' = noise along one axis, of which x and rate are measured.

    Attributes:
        value, rate: Standard deviations of the noise on x and on its rate.
        walk: Standard deviation of d per square root of 1 s.
    """

    value: float
    rate: float
    walk: float

    def gain(self, dt: float, ticks: int = 1) -> np.ndarray:
        """Returns the gains (3, 2) of [x, rate, d], measured every `ticks` periods of `dt` s."""
        F, Q = self._model(dt)
        powers = [np.linalg.matrix_power(F, i) for i in range(ticks)]
        H, R = np.eye(2, 3), np.diag(np.square([self.value, self.rate]))
        Q = sum(power @ Q @ power.T for power in powers)
        P = solve_discrete_are(np.linalg.matrix_power(F, ticks).T, H.T, Q, R)
        return P @ H.T @ np.linalg.inv(H @ P @ H.T + R)

    def periodic_gains(
        self, disturbance: float, dt: float, ticks: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns the gains if d is measured too: at every tick, after x and rate at their ticks.

        They are the limit of the Riccati recursion over a cycle of `ticks` periods.

        Args:
            disturbance: Standard deviation of the noise on d.
            dt: s, period of the ticks.
            ticks: Number of periods between measurements of x and rate.

        Returns:
            (3, 2) for [x, rate]; (ticks, 3) for d, by the ticks since the last [x, rate].
        """
        F, Q = self._model(dt)
        H, R = np.eye(2, 3), np.diag(np.square([self.value, self.rate]))
        by_tick, P = np.zeros((ticks, 3)), Q
        for _ in range(MOST_CYCLES):
            before = P
            L = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
            P = P - L @ H @ P
            for k in range(ticks):
                by_tick[k] = P[2] / (P[2, 2] + disturbance**2)
                P = P - np.outer(by_tick[k], P[2])
                P = F @ P @ F.T + Q
            if np.abs(P - before).max() <= CONVERGED * np.abs(P).max():
                break
        return L, by_tick

    def _model(self, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Returns the transition (3, 3) and the covariance (3, 3) of the noise over `dt` s."""
        F = np.array([[1, dt, dt**2 / 2], [0, 1, dt], [0, 0, 1]])
        G = np.array([dt**2 / 6, dt / 2, 1]) * self.walk * np.sqrt(dt)
        return F, np.outer(G, G)
