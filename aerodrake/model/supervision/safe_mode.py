"""The modes in which a flight is safe, and how setpoints move in them."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

BRAKING_1_S = 4.0
"""1/s, how fast setpoints come to rest, where limits let them."""

TUCKING_RAD_S = 1.5
"""rad/s, of the critically damped motion with which the arm is tucked."""


class SafeMode(IntEnum):
    """What the setpoints are to do, worst last.

    NOMINAL: follow the MPC. HOLD: come to rest and stay. DESCEND: come to rest, go down
    slowly, and tuck the arm. STOP: as before, and the flight is over.
    """

    NOMINAL = 0
    HOLD = 1
    DESCEND = 2
    STOP = 3

    @property
    def label(self) -> str:
        """As in logs and tables."""
        return self.name.lower()


class SafeMotion(NamedTuple):
    """Where setpoints go in safe modes.

    Attributes:
        velocity: (3 + n,) m/s and rad/s, of the setpoints in DESCEND.
        tucked: (n,) rad, joints in DESCEND.
    """

    velocity: np.ndarray
    tucked: np.ndarray

    @classmethod
    def make(cls, config: Supervisor, vehicle: VehicleModel) -> SafeMotion:
        """Of the scenario and its robot."""
        velocity = np.zeros(3 + vehicle.joints)
        velocity[2] = -config.descend_m_s
        return cls(velocity, vehicle.tucked)


@compiled
def safe_acceleration(motion: SafeMotion, mode: float, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(3 + n,) m/s^2 and rad/s^2 of the setpoints, before their limits.

    Args:
        motion: Where they go.
        mode: A `SafeMode`.
        x: (7 + 2 n,) their positions and velocities, in m, rad, m/s and rad/s, and the time, s.
        u: (3 + n,) m/s^2 and rad/s^2, what the MPC asks for.
    """
    if mode < 0.5:  # NOMINAL.
        return u
    m = len(u)
    found = -BRAKING_1_S * x[m : 2 * m]
    if mode > 1.5:  # DESCEND, STOP.
        found += BRAKING_1_S * motion.velocity
        for i in range(3, m):
            away = x[i] - motion.tucked[i - 3]
            found[i] = -(TUCKING_RAD_S**2) * away - 2 * TUCKING_RAD_S * x[m + i]
    return found
