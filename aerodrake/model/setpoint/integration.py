"""Double integration of the commanded accelerations, within limits."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc
from aerodrake.support.compiled import compiled


class SetpointLimits(NamedTuple):
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
    def make(cls, config: Mpc, vehicle: VehicleModel) -> SetpointLimits:
        """For [p_B, q]: the base's from the scenario, the joints' from the URDF."""
        unbounded = np.full(3, np.inf)
        return cls(
            lower=np.concatenate([-unbounded, vehicle.lower]),
            upper=np.concatenate([unbounded, vehicle.upper]),
            velocity=np.concatenate([config.base_velocity_m_s, vehicle.velocity]),
            acceleration=np.concatenate([config.base_acceleration_m_s2, vehicle.acceleration]),
        )


@compiled
def segment(limits: SetpointLimits, x: np.ndarray, u: np.ndarray, dt: float) -> np.ndarray:
    """The polynomials that setpoints follow from one tick to the next.

    Args:
        limits: That they keep, then and later.
        x: (2 m + 1,) positions and velocities at a tick, and its time, s.
        u: (m,) accelerations as commanded.
        dt: s, from tick to tick.

    Returns:
        (3 m + 1,) positions and velocities as in x, accelerations as admissible, the time.
    """
    m = len(u)
    found = np.empty(3 * m + 1)
    found[: 2 * m] = x[: 2 * m]
    found[2 * m : 3 * m] = admissible(limits, x[:m], x[m : 2 * m], u, dt)
    found[-1] = x[-1]
    return found


@compiled
def evaluate(segment: np.ndarray, time: float, first: int, end: int) -> np.ndarray:
    """(3 (end - first),) position, velocity and acceleration at a time, of axes first to end - 1.

    Args:
        segment: (3 m + 1,) as above.
        time: s.
        first, end: Of the m axes, as in a slice.
    """
    m, t, k = len(segment) // 3, time - segment[-1], end - first
    p, v, u = segment[first:end], segment[m + first : m + end], segment[2 * m + first : 2 * m + end]
    found = np.empty(3 * k)
    found[:k], found[k : 2 * k] = integrate(p, v, u, t)
    found[2 * k :] = u
    return found


@compiled
def advanced(segment: np.ndarray, time: float) -> np.ndarray:
    """(2 m + 1,) positions and velocities at a time, and the time: the x of the next segment.

    Args:
        segment: (3 m + 1,) as above.
        time: s.
    """
    m = len(segment) // 3
    found = np.empty(2 * m + 1)
    found[:-1] = evaluate(segment, time, 0, m)[: 2 * m]
    found[-1] = time
    return found


@compiled
def integrate(
    p: np.ndarray, v: np.ndarray, u: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray]:
    """(p, v) a time t s later under a constant acceleration u: exact; p, v and u (m,)."""
    return p + v * t + u * (t * t / 2), v + u * t


@compiled
def admissible(
    limits: SetpointLimits, p: np.ndarray, v: np.ndarray, u: np.ndarray, dt: float
) -> np.ndarray:
    """(m,) the acceleration nearest to u that keeps all limits.

    Held over dt from (p, v), it leaves velocity within its limit, and slow
    enough that the acceleration limit can stop it before a position limit.

    Args:
        limits: That it keeps.
        p, v, u: (m,) each, in the units of `limits`.
        dt: s.
    """
    found = np.empty(len(u))
    for i in range(len(u)):
        a = limits.acceleration[i]
        high = _fastest_approach(limits.upper[i] - p[i], v[i], a, dt)
        low = -_fastest_approach(p[i] - limits.lower[i], -v[i], a, dt)
        low, high = np.maximum(low, -limits.velocity[i]), np.minimum(high, limits.velocity[i])
        found[i] = _clipped(_clipped(u[i], (low - v[i]) / dt, (high - v[i]) / dt), -a, a)
    return found


@compiled
def _clipped(value: float, low: float, high: float) -> float:
    """As `np.clip`; nan stays nan."""
    return np.minimum(np.maximum(value, low), high)


@compiled
def _fastest_approach(distance: float, v: float, a: float, dt: float) -> float:
    """The largest velocity w after dt from which whole ticks of braking stop within a distance.

    Braking takes k a dt off w in k ticks and what is left in one more, so that
    w (n + 1) dt - a dt^2 n (n + 1) / 2 <= room for every n >= 0; the n below
    has the least to spare.

    Args:
        distance: Now, to be covered at most.
        v: Velocity now, towards there; between now and dt the mean of it and w.
        a: Largest deceleration.
        dt: s, a tick.
    """
    room = distance - v * dt / 2
    n = np.floor((np.sqrt(1 + 8 * np.maximum(room, 0.0) / (a * dt**2)) - 1) / 2)
    n = np.minimum(n, 1e6)  # Finite where there is no limit.
    return room / ((n + 1) * dt) + a * dt * n / 2
