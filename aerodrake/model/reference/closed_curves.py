"""Closed reference curves, which repeat lap by lap after a smooth start."""

import math
from abc import abstractmethod
from fractions import Fraction
from functools import cached_property

import numpy as np

from aerodrake.model.reference.reference_curve import Motion, ReferenceCurve, path_diameter
from aerodrake.scenario.references import Clover, FigureEight, Lissajous
from aerodrake.support.compiled import compiled

MAX_LAP_S = 1000.0
"""Longest time in which a curve must return to its start to count as closed."""


class ClosedCurve(ReferenceCurve):
    """A curve through `start` that is followed lap by lap, after a smooth start.

    Args:
        start: (3,) m, where the curve begins.
        start_s: s, in which the pace rises from 0 to 1.
        lap_s: s per lap at full pace; None if the curve does not close.
    """

    def __init__(self, start: np.ndarray, start_s: float, lap_s: float | None):
        self._start, self._start_s, self._lap_s = start, start_s, lap_s

    @abstractmethod
    def shape(self, s: np.ndarray) -> Motion:
        """Returns offsets (T, 3) in m from the start, and their derivatives in m/s.

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

    The tip is at `start` (3,) m. The paper gives neither size nor speed; theta rises by 2 pi
    per lap.
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

    A lap is the least common period of the axes that move. If it is longer than `MAX_LAP_S`,
    the curve has no laps, and its diameter is that of the first `MAX_LAP_S`.
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


@compiled
def smooth_start(times: np.ndarray, start_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Returns the time along a curve whose pace rises from 0 to 1 in `start_s`, and the pace.

    The pace is the smoothstep 3 x^2 - 2 x^3 of x = t / start_s, whose slope is zero at both
    ends: acceleration is continuous.

    Args:
        times: (T,) s, >= 0.
        start_s: s, > 0.

    Returns:
        (T,) s, time along the curve, t - start_s / 2 after the start; and (T,), the pace.
    """
    x = np.minimum(times / start_s, 1.0)
    s = start_s * (x**3 - x**4 / 2) + np.maximum(times - start_s, 0.0)
    return s, x**2 * (3 - 2 * x)


def common_period(periods: np.ndarray) -> float | None:
    """Returns the least common multiple of periods (K,) in s; None if K = 0 or > `MAX_LAP_S`.

    Periods are approximated by fractions with denominators up to 1000, if the error of each
    over the lap is at most 1e-5 of a cycle.
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


@compiled
def _clover(a: float, rate: float, s: np.ndarray) -> Motion:
    """Returns r = a cos(2 theta) with theta = rate s, from the tip at 0, and its derivative."""
    offset, derivative = np.zeros((len(s), 3)), np.zeros((len(s), 3))
    for i in range(len(s)):
        theta = rate * s[i]
        cos, sin = np.cos(theta), np.sin(theta)
        r, dr = a * np.cos(2 * theta), -2 * a * np.sin(2 * theta)
        offset[i, 0], offset[i, 1] = r * cos - a, r * sin
        derivative[i, 0] = rate * (dr * cos - r * sin)
        derivative[i, 1] = rate * (dr * sin + r * cos)
    return offset, derivative
