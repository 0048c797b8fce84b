"""First-order lag of rotor thrust, rising and falling at different speeds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.support.compiled import compiled


class RotorLag(NamedTuple):
    """f' = (command - f) / tau, over a period in which the command is held.

    Attributes:
        up: s, tau where thrust rises.
        down: s, tau where it falls.
        dt: s, period.
    """

    up: float
    down: float
    dt: float


@compiled
def advance(
    lag: RotorLag, thrust: np.ndarray, command: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(thrust at the end, mean thrust) of a period, each (k,) N.

    Args:
        lag: Of the rotors.
        thrust: (k,) N, at the start.
        command: (k,) N, held.
    """
    end, mean = np.empty_like(thrust), np.empty_like(thrust)
    for i in range(len(thrust)):
        tau = lag.up if command[i] > thrust[i] else lag.down
        decay = np.exp(-lag.dt / tau)
        gap = thrust[i] - command[i]
        end[i] = command[i] + gap * decay
        mean[i] = command[i] + gap * (1 - decay) * tau / lag.dt
    return end, mean
