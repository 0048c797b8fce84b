"""What the loops of the flight controller remember from one sample to the next."""

from __future__ import annotations

import numpy as np

from aerodrake.support.compiled import compiled


def initial_memory(p_B: np.ndarray, h_omega: np.ndarray, thrust: np.ndarray) -> np.ndarray:
    """(30 + k,), what the loops remember at rest and level at p_B.

    [position observer (9), attitude observer (6), integral (3) of the position
    error, R_d (9), the last desired attitude, omega_d (3) rad/s, its filtered
    rate, in its own frame, thrust (k) N that the rotors are believed to give].

    Args:
        p_B: (3,) m.
        h_omega: (3,) rad/s^2, what the attitude observer knows already.
        thrust: (k,) N.
    """
    position, attitude = np.concatenate([p_B, np.zeros(6)]), np.concatenate([np.zeros(3), h_omega])
    rest = np.zeros(3)
    return np.concatenate([position, attitude, rest, np.eye(3).ravel(), rest, thrust])


@compiled
def memory_parts(x: np.ndarray) -> tuple[np.ndarray, ...]:
    """The parts of a memory x (30 + k,), as `initial_memory` has them, in their shapes; views."""
    return (
        x[:9].reshape(3, 3),
        x[9:15].reshape(2, 3),
        x[15:18],
        x[18:27].reshape(3, 3),
        x[27:30],
        x[30:],
    )
