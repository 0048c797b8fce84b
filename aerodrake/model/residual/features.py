"""Features of the residual network, and the sizes of its layers."""

import numpy as np

from aerodrake.model.vehicle.rotation import roll_pitch_yaw, rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.support.compiled import compiled

HIDDEN = (32, 32)
"""Units of the hidden layers."""

PHI_SIZE = HIDDEN[-1] + 1
"""Length of phi: the last hidden activations and the 1 that the bias multiplies."""


def feature_names(joints: int) -> list[str]:
    """Returns the names of the 12 + 3 n features with units, in the order of `features`."""
    arm = range(1, joints + 1)
    return [
        *("roll_rad", "pitch_rad", "yaw_rad"),
        *("v_x_m_s", "v_y_m_s", "v_z_m_s"),
        *("omega_x_rad_s", "omega_y_rad_s", "omega_z_rad_s"),
        *(f"q_{i}_rad" for i in arm),
        *(f"qdot_{i}_rad_s" for i in arm),
        *("a_x_m_s2", "a_y_m_s2", "a_z_m_s2"),
        *(f"qddot_{i}_rad_s2" for i in arm),
    ]


@compiled
def features(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Returns the features [Theta_B, v_B, omega_B, q, q', u_{k-1}].

    The paper lists "control inputs". u_k depends on Delta_k, so that inference and
    training use u_{k-1}.

    Args:
        x: (13 + 2 n,), `VehicleState` measured at t_k.
        u: (3 + n,) [p_B,d'', q_d''] in m/s^2 and rad/s^2, applied up to t_k.

    Returns:
        (12 + 3 n,) unscaled; v_B in the world frame, omega_B in the base frame.
    """
    quaternion, _, q, omega_W, v_B, qdot = split_state(x)
    R_B = rotation_matrix(quaternion)
    omega_B = np.zeros(3)
    for i in range(3):
        for j in range(3):
            omega_B[i] += R_B[j, i] * omega_W[j]
    return np.concatenate((roll_pitch_yaw(R_B), v_B, omega_B, q, qdot, u))
