"""Moving air: its gusts, and the force it exerts."""

from __future__ import annotations

import math

import numpy as np

from aerodrake.model.vehicle.rotation import length
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Wind
from aerodrake.support.compiled import compiled


def is_at_rest(config: Wind) -> bool:
    """Whether there is neither wind nor gust, and so no force at all."""
    return not any(config.velocity_m_s) and not any(config.gust_m_s)


def discrete_gusts(config: Wind, dt: float) -> tuple[float, np.ndarray]:
    """The Ornstein-Uhlenbeck process of the gusts, exact at its samples.

    On each axis, x' = -x / T + sigma sqrt(2 / T) times white noise; hence
    x+ = a x + b w with w standard normal, a = exp(-dt / T) and
    b = sigma sqrt(1 - a^2), whose stationary deviation is sigma at any dt.

    Args:
        config: sigma, `gust_m_s`, and T, `gust_correlation_s`.
        dt: s, time from one sample to the next.

    Returns:
        a, and (3,) m/s, b.
    """
    a = math.exp(-dt / config.gust_correlation_s)
    return a, np.array(config.gust_m_s) * math.sqrt(1 - a * a)


@compiled
def drag(quadratic: float, linear: float, v_r: np.ndarray) -> np.ndarray:
    """(3,) N, quadratic |v_r| v_r + linear v_r: the force of air that moves past.

    Args:
        quadratic: N s^2/m^2.
        linear: N s/m.
        v_r: (3,) m/s, the air's velocity less the body's, in any frame; the
            force is in the same one.
    """
    return (quadratic * length(v_r) + linear) * v_r


@compiled
def drag_on_base(quadratic: float, linear: float, air: np.ndarray, x: np.ndarray) -> np.ndarray:
    """(3,) N in the world.

    Args:
        quadratic, linear: N s^2/m^2 and N s/m, as for `drag`.
        air: (3,) m/s, its velocity in the world.
        x: (13 + 2 n,) the vehicle's state, as `VehicleState` has it.
    """
    _, _, _, _, v_B, _ = split_state(x)
    return drag(quadratic, linear, air - v_B)
