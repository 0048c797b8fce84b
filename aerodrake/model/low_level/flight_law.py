"""Position and attitude laws of the base, z up.

H. Cao et al., "ESO-based robust and high-precision tracking control for aerial
manipulation", 2023, as publicly known; the attitude error is that of T. Lee et
al., "Geometric tracking control of a quadrotor UAV on SE(3)", 2010.
"""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import cross, vee
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.scenario import Flight
from aerodrake.support.compiled import compiled


class FlightGains(NamedTuple):
    """Gains of the position law, per world axis, and of the attitude law, per base axis.

    Attributes:
        position: (3,) 1/s^2, k_p.
        velocity: (3,) 1/s, k_v.
        integral: (3,) 1/s^3, k_i.
        attitude: (3,) 1/s^2, k_R.
        rate: (3,) 1/s, k_omega.
    """

    position: np.ndarray
    velocity: np.ndarray
    integral: np.ndarray
    attitude: np.ndarray
    rate: np.ndarray

    @classmethod
    def make(cls, config: Flight) -> Self:
        """Returns the gains of a scenario."""
        position = config.position_gain, config.velocity_gain, config.integral_gain
        gains = *position, config.attitude_gain, config.rate_gain
        return cls(*(np.array(gain, dtype=float) for gain in gains))


@compiled
def position_law(
    gains: FlightGains,
    position_error: np.ndarray,
    velocity_error: np.ndarray,
    feedforward: np.ndarray,
    disturbance: np.ndarray,
    integral: np.ndarray,
) -> np.ndarray:
    """Returns u_v = a_d - k_v (v - v_d) - k_p (p - p_d) - k_i integral - h, m/s^2.

    Args:
        gains: k_p, k_v, k_i.
        position_error: (3,) m, p - p_d.
        velocity_error: (3,) m/s, v - v_d.
        feedforward: (3,) m/s^2, a_d.
        disturbance: (3,) m/s^2, h of the position ESO.
        integral: (3,) m s, of the position error. k_i is 0 by default: h already
            rejects constant disturbances, and an integral spoils the first-order
            response that K_B models.
    """
    return (
        feedforward
        - velocity_error * gains.velocity
        - position_error * gains.position
        - integral * gains.integral
        - disturbance
    )


@compiled
def desired_thrust(u_v: np.ndarray, max_tilt: float) -> np.ndarray:
    """Returns the specific thrust u_v + g (3,) m/s^2, tilted by at most `max_tilt` rad.

    Vertical acceleration has priority over horizontal. Thrust never points down.
    """
    up = max(u_v[2] + GRAVITY, 0.2 * GRAVITY)
    horizontal = np.hypot(u_v[0], u_v[1])
    limit = up * np.tan(max_tilt)
    scale = limit / horizontal if horizontal > limit else 1.0
    return np.array([scale * u_v[0], scale * u_v[1], up])


@compiled
def desired_attitude(thrust: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """Returns the attitude (3, 3) with its z axis along `thrust` (3,) and yaw angle `yaw` rad."""
    z = thrust / np.sqrt(np.sum(thrust * thrust))
    left = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    x = cross(left, z)
    x /= np.sqrt(np.sum(x * x))
    return np.column_stack((x, cross(z, x), z))


@compiled
def attitude_error(R: np.ndarray, R_d: np.ndarray) -> np.ndarray:
    """Returns e_R = vee(R_d^T R - R^T R_d) / 2 (3,) in the base frame; R and R_d (3, 3)."""
    return vee(R_d.T @ R)


@compiled
def attitude_law(
    gains: FlightGains, error: np.ndarray, rate_error: np.ndarray, disturbance: np.ndarray
) -> np.ndarray:
    """Returns u_omega = -k_R e_R - k_omega (omega - omega_d) - h_omega, rad/s^2.

    Args:
        gains: k_R, k_omega.
        error: (3,) e_R.
        rate_error: (3,) rad/s, omega - omega_d in the base frame.
        disturbance: (3,) rad/s^2, h_omega of the attitude ESO.
    """
    return -(error * gains.attitude + rate_error * gains.rate + disturbance)
