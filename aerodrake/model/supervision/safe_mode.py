"""Safe modes, and the motion of the setpoints in them."""

from enum import IntEnum
from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

BRAKING_1_S = 4.0
"""1/s, rate at which setpoint velocities decay to zero, where limits permit it."""

TUCKING_RAD_S = 1.5
"""rad/s, natural frequency of the critically damped motion that tucks the arm."""


class SafeMode(IntEnum):
    """Modes of the setpoint integrator, from the mildest to the worst.

    NOMINAL: follow the MPC. HOLD: come to rest and stay. DESCEND: come to rest, descend
    slowly, and tuck the arm. STOP: as DESCEND, and the flight ends.
    """

    NOMINAL = 0
    HOLD = 1
    DESCEND = 2
    STOP = 3

    @property
    def label(self) -> str:
        """Name in logs and tables."""
        return self.name.lower()


class SafeMotion(NamedTuple):
    """Motion of the setpoints in DESCEND and STOP.

    Attributes:
        velocity: (3 + n,) m/s and rad/s, to which base and joints converge.
        tucked: (n,) rad, joint angles of the tucked arm.
    """

    velocity: np.ndarray
    tucked: np.ndarray

    @classmethod
    def make(cls, config: Supervisor, vehicle: VehicleModel) -> Self:
        """Returns a vertical descent at `config.descend_m_s` with the arm tucked."""
        velocity = np.zeros(3 + vehicle.joints)
        velocity[2] = -config.descend_m_s
        return cls(velocity, vehicle.tucked)


@compiled
def safe_acceleration(
    motion: SafeMotion, mode: float, position: np.ndarray, velocity: np.ndarray, u: np.ndarray
) -> np.ndarray:
    """Returns the accelerations (3 + n,) of the setpoints in m/s^2 and rad/s^2, before limits.

    Args:
        motion: Motion in DESCEND and STOP.
        mode: A `SafeMode`.
        position, velocity: (3 + n,) of the setpoints in m and rad, m/s and rad/s.
        u: (3 + n,) m/s^2 and rad/s^2, command of the MPC.
    """
    if mode == SafeMode.NOMINAL.value:
        return u
    acceleration = -BRAKING_1_S * velocity
    if mode != SafeMode.HOLD.value:
        acceleration += BRAKING_1_S * motion.velocity
        for i in range(3, len(u)):
            away = position[i] - motion.tucked[i - 3]
            acceleration[i] = -(TUCKING_RAD_S**2) * away - 2 * TUCKING_RAD_S * velocity[i]
    return acceleration
