"""References: where the end-effector is to be, and how fast, over time.

Times are reference times in s: 0 is the end of the initial hover. Positions
and velocities are the paper's p_E,d and p_E,d' in the world frame, z up.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from fractions import Fraction
from functools import cached_property

import numpy as np

from aerodrake.model.reference.diameter import path_diameter
from aerodrake.model.reference.pace import smooth_start
from aerodrake.model.reference.waypoints import interpolate_waypoints, read_waypoints
from aerodrake.scenario import (
    Clover,
    FigureEight,
    Hover,
    Lissajous,
    MovingTarget,
    Reference,
    Waypoints,
)
from aerodrake.support.compiled import compiled
from aerodrake.support.files import locate

MAX_LAP_S = 1000.0
"""A curve that takes longer to return to its start counts as one that does not."""

Motion = tuple[np.ndarray, np.ndarray]
"""Positions (T, 3) in m, and their derivatives (T, 3)."""


class ReferenceCurve(ABC):
    """The desired motion of the end-effector."""

    def evaluate(self, times: np.ndarray) -> Motion:
        """Positions (T, 3) in m and velocities (T, 3) in m/s at reference times (T,) in s.

        Before reference time 0 the flight hovers: the position is that at 0,
        and the velocity zero.
        """
        times = np.asarray(times, dtype=float)
        p, v = self._move(np.maximum(times, 0.0))
        return p, np.where(times[:, None] < 0.0, 0.0, v)

    @property
    @abstractmethod
    def diameter_m(self) -> float:
        """d_g: the largest distance between two points of the target trajectory, in m."""

    @property
    def lap(self) -> tuple[float, float] | None:
        """Start and end in s of one whole lap after the smooth start; None without laps."""
        return None

    @abstractmethod
    def _move(self, times: np.ndarray) -> Motion:
        """As `evaluate`, for times (T,) >= 0."""


class HoverCurve(ReferenceCurve):
    """Stays at `start` (3,) m."""

    diameter_m = 0.0

    def __init__(self, config: Hover, start: np.ndarray):
        self._start = start

    def _move(self, times: np.ndarray) -> Motion:
        return np.tile(self._start, (len(times), 1)), np.zeros((len(times), 3))


class MovingTargetCurve(ReferenceCurve):
    """p = target + height z + velocity t: the paper's second experiment.

    It does not begin at `start` (3,) m: catching up is what it asks for. How far the
    target will go is not known, hence its infinite diameter.
    """

    diameter_m = math.inf

    def __init__(self, config: MovingTarget, start: np.ndarray):
        self._origin = np.add(config.target_m, [0.0, 0.0, config.height_m])
        self._velocity = np.array(config.velocity_m_s)

    def _move(self, times: np.ndarray) -> Motion:
        p = self._origin + np.outer(times, self._velocity)
        return p, np.tile(self._velocity, (len(times), 1))


class WaypointCurve(ReferenceCurve):
    """The smooth path through the points of a file.

    Its points are where the file says, whatever `start` (3,) m is; the endpoints
    hold outside its times.

    Raises:
        BadInput: if the file cannot be used.
    """

    def __init__(self, config: Waypoints, start: np.ndarray):
        self._times, points = read_waypoints(locate(config.file))
        self._position = interpolate_waypoints(self._times, points)
        self._velocity = self._position.derivative()

    @cached_property
    def diameter_m(self) -> float:
        """d_g, in m, of samples between the first and the last point."""
        segments = len(self._times) - 1
        samples = segments * max(4, 4096 // segments)
        row = np.linspace(0, segments, samples + 1)
        times = np.interp(row, np.arange(segments + 1), self._times)
        return path_diameter(lambda t: self._move(t)[0], times)

    def _move(self, times: np.ndarray) -> Motion:
        return self._position.vector_values(times).T, self._velocity.vector_values(times).T


class ClosedCurve(ReferenceCurve):
    """A curve that begins at `start` and is run through lap by lap, after a smooth start.

    Args:
        start: (3,) m, where the curve begins.
        start_s: s, in which the pace rises from 0 to 1.
        lap_s: s a lap at full pace; None if the curve does not close.
    """

    def __init__(self, start: np.ndarray, start_s: float, lap_s: float | None):
        self._start = start
        self._start_s = start_s
        self._lap_s = lap_s

    @abstractmethod
    def shape(self, s: np.ndarray) -> Motion:
        """Offsets (T, 3) in m from where the curve begins, and their derivatives in m/s.

        Args:
            s: (T,) s, time along the curve at full pace; the offset at 0 is 0.
        """

    @property
    def lap(self) -> tuple[float, float] | None:
        if self._lap_s is None:
            return None
        return self._start_s, self._start_s + self._lap_s

    def _move(self, times: np.ndarray) -> Motion:
        s, pace = smooth_start(times, self._start_s)
        offset, derivative = self.shape(s)
        return self._start + offset, derivative * pace[:, None]


class CloverCurve(ClosedCurve):
    """r = a cos(2 theta) about a centre at `start` - [a, 0, 0], from the tip of the +x petal.

    That tip is at `start` (3,) m. The paper gives neither size nor speed; theta
    rises by 2 pi / lap_s.
    """

    def __init__(self, config: Clover, start: np.ndarray):
        super().__init__(start, config.start_s, config.lap_s)
        self._amplitude = config.amplitude_m
        self._rate = 2 * math.pi / config.lap_s

    @property
    def diameter_m(self) -> float:
        return 2 * self._amplitude  # From tip to opposite tip; no point is farther out.

    def shape(self, s: np.ndarray) -> Motion:
        return _clover(self._amplitude, self._rate, s)


@compiled
def _clover(a: float, rate: float, s: np.ndarray) -> Motion:
    """r = a cos(2 theta) with theta = rate s, from the tip at theta 0; and its derivative."""
    offset, derivative = np.zeros((len(s), 3)), np.zeros((len(s), 3))
    for i in range(len(s)):
        theta = rate * s[i]
        cos, sin = np.cos(theta), np.sin(theta)
        r, dr = a * np.cos(2 * theta), -2 * a * np.sin(2 * theta)
        offset[i, 0], offset[i, 1] = r * cos - a, r * sin
        derivative[i, 0] = rate * (dr * cos - r * sin)
        derivative[i, 1] = rate * (dr * sin + r * cos)
    return offset, derivative


class FigureEightCurve(ClosedCurve):
    """Gerono's lemniscate [L/2 sin(phi), W/2 sin(2 phi)], from its crossing at `start` (3,) m.

    Its length L is along world x; its width W along world y tilted about x.
    """

    def __init__(self, config: FigureEight, start: np.ndarray):
        super().__init__(start, config.start_s, config.lap_s)
        self._length, self._width, tilt = config.length_m, config.width_m, config.tilt_rad
        self._axes = np.array([[1.0, 0.0, 0.0], [0.0, math.cos(tilt), math.sin(tilt)]])
        self._rate = 2 * math.pi / config.lap_s

    @property
    def diameter_m(self) -> float:
        """Twice the largest radius, by symmetry about the crossing.

        With s = sin(phi)^2 the squared radius is (L/2)^2 s + W^2 s (1 - s).
        """
        half, width = self._length / 2, self._width
        s = min(1.0, (1 + (half / width) ** 2) / 2)
        return 2 * math.sqrt(half**2 * s + width**2 * s * (1 - s))

    def shape(self, s: np.ndarray) -> Motion:
        phi, half = self._rate * s, np.array([self._length, self._width]) / 2
        offset = half * np.stack([np.sin(phi), np.sin(2 * phi)], axis=-1)
        derivative = half * np.stack([np.cos(phi), 2 * np.cos(2 * phi)], axis=-1)
        return offset @ self._axes, self._rate * derivative @ self._axes


class LissajousCurve(ClosedCurve):
    """A_i [sin(2 pi s / T_i + phi_i) - sin(phi_i)] on each world axis i, from `start` (3,) m.

    Its lap is the least common period of the axes that move. Where that is
    longer than `MAX_LAP_S` there is none, and the diameter is that of the
    first `MAX_LAP_S`.
    """

    def __init__(self, config: Lissajous, start: np.ndarray):
        self._amplitude = np.array(config.amplitude_m)
        self._phase = np.array(config.phase_rad)
        self._period = np.array(config.period_s)
        lap_s = common_period(self._period[self._amplitude > 0])
        super().__init__(start, config.start_s, lap_s)

    @cached_property
    def diameter_m(self) -> float:
        """d_g, in m, of samples over a lap, or over `MAX_LAP_S`."""
        span, step = self._lap_s or MAX_LAP_S, self._period.min() / 1024
        times = np.arange(-step, span + step, step)  # Beyond the ends: a maximum may lie there.
        return path_diameter(lambda s: self.shape(s)[0], times)

    def shape(self, s: np.ndarray) -> Motion:
        rate = 2 * math.pi / self._period
        angle = np.outer(s, rate) + self._phase
        offset = self._amplitude * (np.sin(angle) - np.sin(self._phase))
        return offset, self._amplitude * rate * np.cos(angle)


CURVES: dict[type, Callable[..., ReferenceCurve]] = {
    Hover: HoverCurve,
    Clover: CloverCurve,
    FigureEight: FigureEightCurve,
    Lissajous: LissajousCurve,
    MovingTarget: MovingTargetCurve,
    Waypoints: WaypointCurve,
}


def make_reference(config: Reference, start: np.ndarray) -> ReferenceCurve:
    """The curve that a scenario's reference section describes.

    Args:
        config: The section.
        start: (3,) m, initial position of the end-effector in the world, where
            closed curves begin.

    Raises:
        BadInput: if the section names a file that cannot be used.
    """
    return CURVES[type(config)](config, np.array(start, dtype=float))


def hover_then_follow(curve: ReferenceCurve, start: np.ndarray, times: np.ndarray) -> Motion:
    """A flight's reference at times (T,): to stay at `start` (3,) m until 0, then the curve."""
    p, v = curve.evaluate(times)
    return np.where(times[:, None] < 0.0, start, p), v


def common_period(periods: np.ndarray) -> float | None:
    """The least common multiple of periods (K,) in s; None if K = 0 or beyond `MAX_LAP_S`.

    Periods are taken as fractions with denominators up to 1000, as long as
    this misses none of them by more than 1e-5 of a cycle over the lap.
    """
    if not len(periods):
        return None
    fractions = [Fraction(period).limit_denominator(1000) for period in periods]
    lap = math.lcm(*(f.numerator for f in fractions)) / math.gcd(
        *(f.denominator for f in fractions)
    )
    cycles = lap / periods
    closes = np.abs(cycles - np.round(cycles)).max() < 1e-5
    return lap if closes and lap <= MAX_LAP_S else None
