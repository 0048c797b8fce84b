"""Position and attitude laws of the base, z up.

H. Cao et al., "ESO-based robust and high-precision tracking control for aerial
manipulation", 2023, as publicly known; the attitude error is that of T. Lee et
al., "Geometric tracking control of a quadrotor UAV on SE(3)", 2010.
"""

from __future__ import annotations

import numpy as np
from pydrake.math import VectorToSkewSymmetric

from aerodrake.model.vehicle import GRAVITY
from aerodrake.scenario import Flight

UP = np.array([0.0, 0.0, 1.0])


def position_law(
    gains: Flight,
    position_error: np.ndarray,
    velocity_error: np.ndarray,
    feedforward: np.ndarray,
    disturbance: np.ndarray,
    integral: np.ndarray,
) -> np.ndarray:
    """u_v = a_d - k_v (v - v_d) - k_p (p - p_d) - k_i integral - h, m/s^2.

    Args:
        gains: Those of the scenario.
        position_error: (3,) m, p - p_d.
        velocity_error: (3,) m/s, v - v_d.
        feedforward: (3,) m/s^2, a_d.
        disturbance: (3,) m/s^2, h of the position ESO.
        integral: (3,) m s, of the position error; off by default, since h
            already rejects constants and an integral spoils the first-order
            response that K_B models.
    """
    return (
        feedforward
        - velocity_error * gains.velocity_gain
        - position_error * gains.position_gain
        - integral * gains.integral_gain
        - disturbance
    )


def desired_thrust(u_v: np.ndarray, max_tilt: float) -> np.ndarray:
    """(3,) m/s^2, the specific thrust u_v + g, tilted by at most `max_tilt` rad.

    Height goes before horizontal acceleration, and thrust never points down.
    """
    thrust = u_v + GRAVITY * UP
    thrust[2] = max(thrust[2], 0.2 * GRAVITY)
    horizontal = np.hypot(thrust[0], thrust[1])
    most = thrust[2] * np.tan(max_tilt)
    if horizontal > most:
        thrust[:2] *= most / horizontal
    return thrust


def desired_attitude(thrust: np.ndarray, yaw: float = 0.0) -> np.ndarray:
    """(3, 3), the attitude whose z axis is along `thrust` and whose yaw angle is `yaw` rad."""
    z = thrust / np.linalg.norm(thrust)
    left = np.array([-np.sin(yaw), np.cos(yaw), 0.0])
    x = VectorToSkewSymmetric(left) @ z
    x /= np.linalg.norm(x)
    return np.column_stack([x, VectorToSkewSymmetric(z) @ x, z])


def attitude_error(R: np.ndarray, R_d: np.ndarray) -> np.ndarray:
    """(3,) e_R = vee(R_d' R - R' R_d) / 2 in the base frame (Lee et al. 2010)."""
    S = R_d.T @ R
    return 0.5 * np.array([S[2, 1] - S[1, 2], S[0, 2] - S[2, 0], S[1, 0] - S[0, 1]])


def attitude_law(
    gains: Flight,
    error: np.ndarray,
    rate_error: np.ndarray,
    disturbance: np.ndarray,
) -> np.ndarray:
    """u_omega = -k_R e_R - k_omega (omega - omega_d) - h_omega, rad/s^2.

    Args:
        gains: Those of the scenario.
        error: (3,) e_R.
        rate_error: (3,) rad/s, omega - omega_d in the base frame.
        disturbance: (3,) rad/s^2, h_omega of the attitude ESO.
    """
    return -(error * gains.attitude_gain + rate_error * gains.rate_gain + disturbance)
