"""Initial state x_0 of the equivalent model, from measurement, setpoints and the last tick."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import cross, rotation_matrix
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


class Thrust(NamedTuple):
    """Accelerations of the base by cause.

    Attributes:
        b: (3,) m/s^2, by thrust along the measured attitude, and gravity.
        r: (3,) m/s^3, rate of b due to rotation of the base; its z component, which
            follows the magnitude of thrust, is 0.
        d: (3,) m/s^2, by all other forces.
        h: (3,) m/s^2, the flight controller's estimate of d.
    """

    b: np.ndarray
    r: np.ndarray
    d: np.ndarray
    h: np.ndarray

    @classmethod
    def make(
        cls,
        state: VehicleState,
        specific_thrust: float,
        external_acceleration: np.ndarray,
        disturbance: np.ndarray,
    ) -> Self:
        """Makes it from the measured state and outputs of filter and flight controller.

        Args:
            state: Measured attitude and angular velocity.
            specific_thrust: m/s^2, collective thrust over mass.
            external_acceleration: (3,) m/s^2, d.
            disturbance: (3+,) m/s^2, h first.
        """
        b, r = thrust_along(state.quaternion, state.omega_W, specific_thrust)
        return cls(b, r, external_acceleration, disturbance[:3])


NO_THRUST = Thrust(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
"""Accelerations of zero, for models without thrust states."""


class Signals(NamedTuple):
    """Signals at a tick from which x_0 follows.

    Attributes:
        p_B, v_B: (3,) m and m/s, measured.
        base_setpoint: (9,) [p_d, v_d, a_d] in m, m/s, m/s^2; a_d was applied since the last tick.
        joint_setpoint: (3 n,) [q_d, q_d', q_d''] in rad, rad/s, rad/s^2; q_d'' likewise.
        thrust: Accelerations of the base.
    """

    p_B: np.ndarray
    v_B: np.ndarray
    base_setpoint: np.ndarray
    joint_setpoint: np.ndarray
    thrust: Thrust = NO_THRUST


class StateLayout(NamedTuple):
    """Indices of the quantities in x.

    Attributes:
        base: (4, 3), indices of p_B, p_B', p_B,d and p_B,d'.
        thrust: (4, 3), indices of the fields of a `Thrust`; (0, 3) in models without thrust states.
        joints: (2, n), indices of q and q'.
        hidden: (k,), indices of the states that are not measured.
        A, B: (k, nx) and (k, 3 + n), rows of the model for the hidden states.
        base_is_commanded: True if x_0 takes the base from its setpoint.
    """

    base: np.ndarray
    thrust: np.ndarray
    joints: np.ndarray
    hidden: np.ndarray
    A: np.ndarray
    B: np.ndarray
    base_is_commanded: bool


@compiled
def thrust_along(
    quaternion: np.ndarray, omega_W: np.ndarray, specific_thrust: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns b (3,) m/s^2 and r (3,) m/s^3 of a `Thrust` along the base's axis.

    Args:
        quaternion: (4,), attitude of the base.
        omega_W: (3,) rad/s, its angular velocity in the world.
        specific_thrust: m/s^2, collective thrust over mass.
    """
    R_B = rotation_matrix(quaternion)
    axis = np.array([R_B[0, 2], R_B[1, 2], R_B[2, 2]])
    b, r = specific_thrust * axis, specific_thrust * cross(omega_W, axis)
    b[2] -= GRAVITY
    r[2] = 0.0
    return b, r


@compiled
def initial_state(
    layout: StateLayout, signals: Signals, last: np.ndarray, has_last: bool
) -> np.ndarray:
    """Returns x_0 (nx,): see `EquivalentModel.initial_state`.

    Args:
        layout: Layout of the model's state.
        signals: Signals at this tick.
        last: (nx,), x_0 of the last tick.
        has_last: False without a last tick; then hidden states are zero.
    """
    base, joint = signals.base_setpoint, signals.joint_setpoint
    n = layout.joints.shape[1]
    x = np.zeros(len(last))
    for i in range(3):
        p_d, v_d = base[i], base[3 + i]
        x[layout.base[0, i]] = p_d if layout.base_is_commanded else signals.p_B[i]
        x[layout.base[1, i]] = v_d if layout.base_is_commanded else signals.v_B[i]
        x[layout.base[2, i]], x[layout.base[3, i]] = p_d, v_d
        if len(layout.thrust):
            b, r, d, h = signals.thrust
            x[layout.thrust[0, i]], x[layout.thrust[1, i]] = b[i], r[i]
            x[layout.thrust[2, i]], x[layout.thrust[3, i]] = d[i], h[i]
    for j in range(n):
        x[layout.joints[0, j]], x[layout.joints[1, j]] = joint[j], joint[n + j]
    if has_last:
        u = np.concatenate((base[6:], joint[2 * n :]))
        hidden = layout.A @ last + layout.B @ u
        for k in range(len(layout.hidden)):
            x[layout.hidden[k]] = hidden[k]
    return x
