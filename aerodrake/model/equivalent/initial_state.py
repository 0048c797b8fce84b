"""The state of the equivalent model at a tick, from measurement, command and the tick before."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.rotation import cross, rotation_matrix
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.support.compiled import compiled


class Thrust(NamedTuple):
    """What accelerates the base.

    Attributes:
        b: (3,) m/s^2, by thrust along the measured attitude, and gravity.
        r: (3,) m/s^3, how fast b turns with the base; none along z, where it
            changes with the size of thrust.
        d: (3,) m/s^2, by all else.
        h: (3,) m/s^2, what the flight controller takes d for.
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
    ) -> Thrust:
        """From the measured state and what the flight controller tells.

        Args:
            state: Attitude and rates.
            specific_thrust: m/s^2, collective thrust over mass.
            external_acceleration: (3,) m/s^2, d.
            disturbance: (3+,) m/s^2, h first.
        """
        b, r = thrust_along(state.quaternion, state.omega_W, specific_thrust)
        return cls(b, r, external_acceleration, disturbance[:3])


NO_THRUST = Thrust(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3))
"""Where nobody tells of any."""


class Places(NamedTuple):
    """Where each quantity stands in x.

    Attributes:
        base: (4, 3), p_B, p_B', p_B,d and p_B,d'.
        thrust: (4, 3), those of a `Thrust`; (0, 3) in models that have none.
        joints: (2, n), q and q'.
        hidden: (k,), what nobody measures.
        A, B: (k, nx) and (k, 3 + n), their rows of the model.
        believes_command: Whether the base is where it is commanded.
    """

    base: np.ndarray
    thrust: np.ndarray
    joints: np.ndarray
    hidden: np.ndarray
    A: np.ndarray
    B: np.ndarray
    believes_command: bool


@compiled
def thrust_along(
    quaternion: np.ndarray, omega_W: np.ndarray, specific_thrust: float
) -> tuple[np.ndarray, np.ndarray]:
    """(b, r) of a `Thrust` along the base's axis, (3,) m/s^2 and (3,) m/s^3.

    Args:
        quaternion: (4,), of the base.
        omega_W: (3,) rad/s, its rates in the world.
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
    places: Places,
    p_B: np.ndarray,
    v_B: np.ndarray,
    base_setpoint: np.ndarray,
    joint_setpoint: np.ndarray,
    thrust: Thrust,
    last: np.ndarray,
    is_known: bool,
) -> np.ndarray:
    """(nx,), x_0: see `EquivalentModel.initial_state`.

    Args:
        places: Of the model.
        p_B, v_B, base_setpoint, joint_setpoint, thrust: As there.
        last: (nx,), x_0 of the tick before, if
        is_known: there was one; else hidden states are zero.
    """
    n = places.joints.shape[1]
    x = np.zeros(len(last))
    for i in range(3):
        p_d, v_d = base_setpoint[i], base_setpoint[3 + i]
        x[places.base[0, i]] = p_d if places.believes_command else p_B[i]
        x[places.base[1, i]] = v_d if places.believes_command else v_B[i]
        x[places.base[2, i]], x[places.base[3, i]] = p_d, v_d
        if len(places.thrust):
            x[places.thrust[0, i]], x[places.thrust[1, i]] = thrust.b[i], thrust.r[i]
            x[places.thrust[2, i]], x[places.thrust[3, i]] = thrust.d[i], thrust.h[i]
    for j in range(n):
        x[places.joints[0, j]], x[places.joints[1, j]] = joint_setpoint[j], joint_setpoint[n + j]
    if is_known:
        u = np.concatenate((base_setpoint[6:], joint_setpoint[2 * n :]))
        hidden = places.A @ last + places.B @ u
        for k in range(len(places.hidden)):
            x[places.hidden[k]] = hidden[k]
    return x
