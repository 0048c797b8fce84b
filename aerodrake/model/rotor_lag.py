"""First-order lag of rotor thrust, rising and falling at different speeds."""

from __future__ import annotations

import numpy as np


class RotorLag:
    """f' = (command - f) / tau, over a period in which the command is held.

    Args:
        lag_up: s, tau where thrust rises.
        lag_down: s, tau where it falls.
        dt: s, period.
    """

    def __init__(self, lag_up: float, lag_down: float, dt: float):
        self._up, self._down, self._dt = lag_up, lag_down, dt

    def advance(self, thrust: np.ndarray, command: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(thrust at the end, mean thrust), each (k,) N, from thrust (k,) N at the start."""
        tau = np.where(command > thrust, self._up, self._down)
        decay = np.exp(-self._dt / tau)
        gap = thrust - command
        return command + gap * decay, command + gap * (1 - decay) * tau / self._dt
