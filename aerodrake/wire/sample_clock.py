"""Clock of a station's samples, as the coordinator that follows them estimates it."""

import math
import statistics
from collections import deque
from typing import NamedTuple

from aerodrake.model.sensing.sample_check import MAX_MAGNITUDE

GAIN = 0.1
"""Gain of the estimated offset for each sample."""

HYSTERESIS = 0.1
"""Offset above half a period, in periods, from which the adjacent multiple is the nearest one."""

REORDERED = 10
"""Number of periods by which a sample may be late, since networks reorder messages."""

INTERVALS = 50
"""Number of intervals between samples whose median is their period."""

TOLERANCE = 0.1
"""Largest relative error of the samples' period that is not reported."""


class Assignment(NamedTuple):
    """Result for a sample.

    Attributes:
        time: s, multiple of the period; None if the sample is not used.
        problem: Expectation that the sample does not meet; empty if there is none.
        got: Measured value, instead of the expected one.
    """

    time: float | None
    problem: str = ""
    got: str = ""


class SampleClock:
    """Assigns samples to the nearest multiples of the sample period.

    The times of samples may have jitter and a constant offset, and their clock may drift against
    their period. Their offset from the multiples is the state of a first-order phase-locked loop:

        index = round((t - offset) / period),   offset += GAIN (t - index period - offset)

    Successive samples therefore have successive multiples, even if the offset is about half a
    period. If it has drifted to more, it changes by one period. That skips no tick, provided that
    a tick has two or more samples.

    Args:
        period: s, between samples.
        samples_per_tick: Number of sample periods in a period of the coordinator's ticks.
        longest_gap: s, time without samples after which others do not belong to the flight.
    """

    def __init__(self, period: float, samples_per_tick: int, longest_gap: float):
        self._period, self._samples_per_tick = period, samples_per_tick
        self._longest_gap = longest_gap
        self._offset: float | None = None  # s; None before the first sample.
        self._last = -math.inf  # s, time of the last sample.
        self._index = -1  # Multiple of the period that was assigned to it.
        self._intervals: deque[float] = deque(maxlen=INTERVALS)

    def assign(self, time: float) -> Assignment:
        """Returns the multiple of the period for a sample's time in s, in whole microseconds.

        Repeated and late samples are not used, nor is one of two samples for the same multiple.
        """
        if self._last - REORDERED * self._period < time <= self._last:
            return Assignment(None)
        is_first = self._offset is None
        latest = MAX_MAGNITUDE if is_first else min(MAX_MAGNITUDE, self._last + self._longest_gap)
        if not max(self._last, -self._period / 2) <= time < latest:
            expected = "ascending times in s since the start of the flight"
            return Assignment(None, f"samples are ignored: expected {expected}", f"{time:g} s")
        if is_first:
            self._offset = time - round(time / self._period) * self._period
        else:
            self._intervals.append(time - self._last)
        self._last = time
        index = self._follow(time)
        is_used = index > self._index
        self._index = max(index, self._index)
        instant = round(1e6 * index * self._period) / 1e6 if is_used else None
        return Assignment(instant, *self._check_period())

    def _follow(self, time: float) -> int:
        """Returns the multiple for a sample, and updates the offset."""
        index = round((time - self._offset) / self._period)
        self._offset += GAIN * (time - index * self._period - self._offset)
        limit = (0.5 + HYSTERESIS) * self._period
        if self._offset > limit and index % self._samples_per_tick == 0:
            self._offset -= self._period  # Skips the multiple after a tick.
        elif self._offset < -limit:
            self._offset += self._period  # The next sample has the same multiple.
        return index

    def _check_period(self) -> tuple[str, str]:
        """Returns the expected and the measured period if they differ, else empty strings."""
        if len(self._intervals) < INTERVALS:
            return "", ""
        median = statistics.median(self._intervals)
        if abs(median - self._period) <= TOLERANCE * self._period:
            return "", ""
        expected = f"expected samples every {self._period:g} s (rates.sensor_period_s)"
        return expected, f"every {median:.3g} s; each tick uses the nearest one"
