"""First-order lag of rotor thrust, with different time constants for rising and falling."""

from typing import NamedTuple

import numpy as np

from aerodrake.support.compiled import compiled


class RotorLag(NamedTuple):
    """Time constants of f' = (command - f) / tau, and the period of constant commands.

    Attributes:
        up: s, tau of rising thrust.
        down: s, tau of falling thrust.
        dt: s, period.
    """

    up: float
    down: float
    dt: float


@compiled
def advance(
    lag: RotorLag, thrust: np.ndarray, command: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the thrust at the end of a period, and its mean over it, (k,) N each.

    Args:
        lag: Lag of the rotors.
        thrust: (k,) N, at the start.
        command: (k,) N, constant over the period.
    """
    end, mean = np.empty_like(thrust), np.empty_like(thrust)
    for i in range(len(thrust)):
        tau = lag.up if command[i] > thrust[i] else lag.down
        decay = np.exp(-lag.dt / tau)
        gap = thrust[i] - command[i]
        end[i] = command[i] + gap * decay
        mean[i] = command[i] + gap * (1 - decay) * tau / lag.dt
    return end, mean
