"""Wind: gusts, variation in space, and drag."""

import math
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import length
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Wind
from aerodrake.support.compiled import compiled


def is_at_rest(config: Wind) -> bool:
    """Returns True if there is neither wind nor gust nor wave."""
    return not any((*config.velocity_m_s, *config.gust_m_s, *config.wave_m_s))


def is_uniform(config: Wind) -> bool:
    """Returns True if the wind is the same everywhere."""
    has_profile = config.shear_exponent != 0 and any(config.velocity_m_s)
    return not has_profile and not any(config.wave_m_s)


class WindField(NamedTuple):
    """Wind as a function of the position: a power law over the height, and a wave.

    v(p) = v_0 + v_mean ((z / z_ref)^a - 1) + v_wave sin(k . p), where v_0 is the wind at the
    reference height without the wave. Below the ground z is 0. The power law is Hellmann's.

    Attributes:
        mean: (3,) m/s, v_mean.
        exponent: a.
        reference: m, z_ref.
        wave: (3,) m/s, v_wave.
        wave_number: (3,) rad/m, k.
    """

    mean: np.ndarray
    exponent: float
    reference: float
    wave: np.ndarray
    wave_number: np.ndarray

    @classmethod
    def make(cls, config: Wind) -> Self:
        """Returns the field of a scenario."""
        return cls(
            mean=np.array(config.velocity_m_s),
            exponent=config.shear_exponent,
            reference=config.reference_height_m,
            wave=np.array(config.wave_m_s),
            wave_number=np.array(config.wave_rad_m),
        )


@compiled
def wind_at(field: WindField, air: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Returns the velocity of the air (3,) m/s at a position.

    Args:
        field: The field.
        air: (3,) m/s, v_0.
        p: (3,) m, position in the world.
    """
    profile = (max(p[2], 0.0) / field.reference) ** field.exponent - 1
    return air + profile * field.mean + np.sin(field.wave_number @ p) * field.wave


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
