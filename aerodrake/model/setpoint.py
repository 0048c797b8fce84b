"""Double integration of the commanded accelerations, within limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from aerodrake.model.vehicle import Vehicle
from aerodrake.scenario import Mpc


@dataclass(frozen=True)
class SetpointLimits:
    """Limits of a vector of setpoints; infinite where there is none.

    Attributes:
        lower, upper: (m,) of position, m or rad.
        velocity: (m,) of its magnitude, m/s or rad/s.
        acceleration: (m,) of its magnitude, m/s^2 or rad/s^2.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def make(cls, config: Mpc, vehicle: Vehicle) -> SetpointLimits:
        """For [p_B, q]: the base's from the scenario, the joints' from the URDF."""
        unbounded = np.full(3, np.inf)
        return cls(
            lower=np.concatenate([-unbounded, vehicle.lower]),
            upper=np.concatenate([unbounded, vehicle.upper]),
            velocity=np.concatenate([config.base_velocity_m_s, vehicle.velocity]),
            acceleration=np.concatenate([config.base_acceleration_m_s2, vehicle.acceleration]),
        )

    def admissible(self, p: np.ndarray, v: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
        """(m,) the acceleration nearest to u that keeps all limits.

        Held over dt from (p, v), it leaves velocity within its limit, and slow
        enough that the acceleration limit can stop it before a position limit.
        """
        a = self.acceleration
        low = np.maximum(-self.velocity, -_fastest_approach(-p, -v, -self.lower, a, dt))
        high = np.minimum(self.velocity, _fastest_approach(p, v, self.upper, a, dt))
        return np.clip(np.clip(u, (low - v) / dt, (high - v) / dt), -a, a)


def integrate(
    p: np.ndarray, v: np.ndarray, u: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray]:
    """(position, velocity) a time t after (p, v) under a constant acceleration u: exact."""
    return p + v * t + u * (t**2 / 2), v + u * t


def _fastest_approach(
    p: np.ndarray, v: np.ndarray, upper: np.ndarray, a: np.ndarray, dt: float
) -> np.ndarray:
    """The largest velocity w after dt from which whole ticks of braking stop before `upper`.

    Braking takes k a dt off w in k ticks and what is left in one more, so that
    w (n + 1) dt - a dt^2 n (n + 1) / 2 <= room for every n >= 0; the n below
    has the least to spare.
    """
    room = upper - p - v * dt / 2
    n = np.floor((np.sqrt(1 + 8 * np.maximum(room, 0.0) / (a * dt**2)) - 1) / 2)
    n = np.minimum(n, 1e6)  # Finite where there is no limit.
    return room / ((n + 1) * dt) + a * dt * n / 2
