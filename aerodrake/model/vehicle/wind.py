"""Wind: gusts and drag."""

import math

import numpy as np

from aerodrake.model.vehicle.rotation import length
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Wind
from aerodrake.support.compiled import compiled


def is_at_rest(config: Wind) -> bool:
    """Returns True if there is neither wind nor gust."""
    return not any(config.velocity_m_s) and not any(config.gust_m_s)


def discrete_gusts(config: Wind, dt: float) -> tuple[float, np.ndarray]:
    """Returns the Ornstein-Uhlenbeck process of the gusts, discretised exactly.

    On each axis, x' = -x / T + sigma sqrt(2 / T) times white noise; hence
    x+ = a x + b w with w standard normal, a = exp(-dt / T) and
    b = sigma sqrt(1 - a^2), whose stationary deviation is sigma at any dt.

    Args:
        config: sigma, `gust_m_s`, and T, `gust_correlation_s`.
        dt: s, sample period.

    Returns:
        a, and b (3,) m/s.
    """
    a = math.exp(-dt / config.gust_correlation_s)
    return a, np.array(config.gust_m_s) * math.sqrt(1 - a * a)


@compiled
def drag(quadratic: float, linear: float, v_r: np.ndarray) -> np.ndarray:
    """Returns the drag force (3,) N, quadratic |v_r| v_r + linear v_r.

    Args:
        quadratic: N s^2/m^2.
        linear: N s/m.
        v_r: (3,) m/s, velocity of the air relative to the body, in any frame; the
            force is in the same frame.
    """
    return (quadratic * length(v_r) + linear) * v_r


@compiled
def drag_on_base(quadratic: float, linear: float, air: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Returns the drag force on the base, (3,) N in the world.

    Args:
        quadratic, linear: N s^2/m^2 and N s/m, coefficients of `drag`.
        air: (3,) m/s, velocity of the air in the world.
        x: (13 + 2 n,) state of the vehicle.
    """
    return drag(quadratic, linear, air - split_state(x).v_B)
