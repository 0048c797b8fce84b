"""Setpoints by double integration of commanded accelerations, within limits."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Mpc
from aerodrake.support.compiled import compiled


class SetpointLimits(NamedTuple):
    """Limits of the setpoints of m axes; infinite for axes without a limit.

    Attributes:
        lower, upper: (m,) bounds of the position, m or rad.
        velocity: (m,) largest speed, m/s or rad/s.
        acceleration: (m,) largest magnitude of the acceleration, m/s^2 or rad/s^2.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray

    @classmethod
    def make(cls, config: Mpc, vehicle: VehicleModel) -> Self:
        """Returns the limits of [p_B, q]: base by the scenario, joints by the URDF."""
        unbounded = np.full(3, np.inf)
        return cls(
            lower=np.concatenate([-unbounded, vehicle.lower]),
            upper=np.concatenate([unbounded, vehicle.upper]),
            velocity=np.concatenate([config.base_velocity_m_s, vehicle.velocity]),
            acceleration=np.concatenate([config.base_acceleration_m_s2, vehicle.acceleration]),
        )


class Segment(NamedTuple):
    """Quadratic polynomials of the setpoints of m axes, from one tick to the next.

    Attributes:
        position: (m,) m and rad, at the tick.
        velocity: (m,) m/s and rad/s, at the tick.
        acceleration: (m,) m/s^2 and rad/s^2, constant.
        time_s: s, time of the tick.
    """

    position: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    time_s: float

    @staticmethod
    def size(axes: int) -> int:
        """Returns the length of the vector of a segment."""
        return 3 * axes + 1

    @staticmethod
    def axes(size: int) -> int:
        """Returns the number of axes m of a segment whose vector has this length."""
        return size // 3

    def to_vector(self) -> np.ndarray:
        """Returns the vector (3 m + 1,), the inverse of `split_segment`."""
        return np.concatenate([self.position, self.velocity, self.acceleration, [self.time_s]])


@compiled
def split_segment(vector: np.ndarray) -> Segment:
    """Returns the parts of a segment's vector (3 m + 1, ...) as views, not copies."""
    m = len(vector) // 3
    return Segment(vector[:m], vector[m : 2 * m], vector[2 * m : 3 * m], vector[-1])


@compiled
def evaluate(vector: np.ndarray, time: float, first: int, end: int) -> np.ndarray:
    """Returns position, velocity and acceleration (3 (end - first),) of some axes at a time.

    Args:
        vector: (3 m + 1,) a segment.
        time: s.
        first, end: Range of the axes, as in a slice.
    """
    segment, k = split_segment(vector), end - first
    p, v, u = segment.position[first:end], segment.velocity[first:end], segment.acceleration
    setpoint = np.empty(3 * k)
    setpoint[:k], setpoint[k : 2 * k] = integrate(p, v, u[first:end], time - segment.time_s)
    setpoint[2 * k :] = u[first:end]
    return setpoint


@compiled
def start(limits: SetpointLimits, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Returns first p and v (3 + n,): those of a measured state (13 + 2 n,), within limits."""
    _, p_B, q, _, v_B, qdot = split_state(state)
    p, v = np.concatenate((p_B, q)), np.concatenate((v_B, qdot))
    for i in range(len(p)):
        p[i] = _clipped(p[i], limits.lower[i], limits.upper[i])
        v[i] = _clipped(v[i], -limits.velocity[i], limits.velocity[i])
    return p, v


@compiled
def integrate(
    p: np.ndarray, v: np.ndarray, u: np.ndarray, t: float
) -> tuple[np.ndarray, np.ndarray]:
    """Returns p and v (m,) after t s of constant acceleration; p, v and u (m,)."""
    return p + v * t + u * (t * t / 2), v + u * t


@compiled
def admissible(
    limits: SetpointLimits, p: np.ndarray, v: np.ndarray, u: np.ndarray, dt: float
) -> np.ndarray:
    """Returns the acceleration (m,) nearest to u that keeps all limits.

    After dt of it from (p, v), the velocity is within its limit, and small enough for the
    acceleration limit to stop it before a position limit.

    Args:
        limits: The limits to keep.
        p, v, u: (m,) position, velocity and commanded acceleration, in the units of `limits`.
        dt: s.
    """
    allowed = np.empty(len(u))
    for i in range(len(u)):
        a = limits.acceleration[i]
        high = _fastest_approach(limits.upper[i] - p[i], v[i], a, dt)
        low = -_fastest_approach(p[i] - limits.lower[i], -v[i], a, dt)
        low, high = np.maximum(low, -limits.velocity[i]), np.minimum(high, limits.velocity[i])
        allowed[i] = _clipped(_clipped(u[i], (low - v[i]) / dt, (high - v[i]) / dt), -a, a)
    return allowed


@compiled
def braking(v: np.ndarray, most: np.ndarray, stages_s: np.ndarray) -> np.ndarray:
    """Returns the inputs (m N,) over a horizon that brake from v and then rest, axis by axis.

    Each input is divided by its limit.

    Args:
        v: (m,) m/s and rad/s, current velocities.
        most: (m,) m/s^2 and rad/s^2, limits of the accelerations.
        stages_s: (N,) s, durations of the stages.
    """
    m, N = len(v), len(stages_s)
    z = np.empty(m * N)
    for i in range(m):
        speed = v[i]
        for k in range(N):
            u = min(max(-speed / stages_s[k], -most[i]), most[i])
            speed += u * stages_s[k]
            z[i * N + k] = u / most[i]
    return z


@compiled
def _clipped(value: float, low: float, high: float) -> float:
    """Returns `np.clip(value, low, high)`; NaN stays NaN."""
    return np.minimum(np.maximum(value, low), high)


@compiled
def _fastest_approach(distance: float, v: float, a: float, dt: float) -> float:
    """Returns the largest velocity w after dt from which braking stops within a distance.

    Braking lasts whole ticks. It reduces w by a dt in each, and by the rest in the last, so that
    w (n + 1) dt - a dt^2 n (n + 1) / 2 <= room for every n >= 0. The n below is the tightest.

    Args:
        distance: Largest distance to cover from now on.
        v: Current velocity in this direction; until dt the mean velocity is (v + w) / 2.
        a: Largest deceleration.
        dt: s, duration of a tick.
    """
    room = distance - v * dt / 2
    n = np.floor((np.sqrt(1 + 8 * np.maximum(room, 0.0) / (a * dt**2)) - 1) / 2)
    n = np.minimum(n, 1e6)  # Finite without a limit.
    return room / ((n + 1) * dt) + a * dt * n / 2
