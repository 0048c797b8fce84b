"""Assignment of samples to ticks, with jitter, offsets, drift, losses and wrong clocks."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.wire.sample_clock import HYSTERESIS, INTERVALS, SampleClock

PERIOD, PER_TICK, GAP = 0.01, 2, 1.0


def assign(times, per_tick=PER_TICK, period=PERIOD):
    """Returns the assignments to samples at these times, which messages round to microseconds."""
    clock = SampleClock(period, per_tick, GAP)
    return [clock.assign(round(1e6 * time) / 1e6) for time in times]


def indices(assignments, period=PERIOD):
    """Returns the multiples of the period that were assigned."""
    return [round(a.time / period) for a in assignments if a.time is not None]


@given(st.integers(1, 100), st.integers(0, 10**6))
def test_samples_on_the_grid_keep_their_time_bit_for_bit(period_ms, first):
    period = period_ms / 1000
    times = [round(1e6 * (first + i) * period) / 1e6 for i in range(20)]
    times = [time for time in times if time < 5000]
    assert [(a.time, a.problem) for a in assign(times, period=period)] == [(t, "") for t in times]


@given(
    st.integers(1, 4),
    st.floats(-0.49, 1.0),
    st.floats(0.0, 0.2),
    st.floats(-300e-6, 300e-6),
    st.integers(0, 2**32 - 1),
)
def test_every_tick_has_the_nearest_sample(per_tick, offset, jitter, drift, seed):
    """Jitter and offset are in periods; no sample is lost."""
    random, i = np.random.default_rng(seed), np.arange(400)
    times = PERIOD * (i * (1 + drift) + offset + random.uniform(-jitter, jitter, len(i)))
    times = times[times >= -PERIOD / 2]
    assignments = assign(times, per_tick)
    assert {a.problem for a in assignments} == {""}
    used = indices(assignments)
    assert (np.diff(used) > 0).all()
    for assignment, time in zip(assignments, times, strict=True):
        if assignment.time is not None:
            most = (0.5 + HYSTERESIS + 2 * jitter) * PERIOD
            assert abs(assignment.time - time) <= most + 1e-6
    if per_tick > 1:
        ticks = {index for index in range(used[0], used[-1]) if index % per_tick == 0}
        assert ticks <= set(used)


@pytest.mark.parametrize("ppm", [100, -100])
def test_a_drifting_clock_is_followed_for_minutes(ppm):
    times = PERIOD * (1 + 1e-6 * ppm) * np.arange(18_000)
    assignments = assign(times)
    used = indices(assignments)
    assert set(range(0, used[-1], PER_TICK)) <= set(used)
    # The clock has gained or lost 18 ms, that is two samples.
    assert len(times) - len(used) == (0 if ppm > 0 else 2)
    assert used[-1] - used[0] - len(used) + 1 == (2 if ppm > 0 else 0)
    errors = [
        abs(a.time - t) for a, t in zip(assignments, times, strict=True) if a.time is not None
    ]
    assert max(errors) < (0.5 + HYSTERESIS) * PERIOD + 1e-4


@given(st.lists(st.integers(1, 20), min_size=1, max_size=50), st.floats(-0.4, 0.4))
def test_gaps_are_gaps(steps, offset):
    multiples = np.cumsum([1, *steps])
    assert indices(assign(PERIOD * (multiples + offset))) == multiples.tolist()


@given(st.permutations(range(8)), st.floats(-0.3, 0.3))
def test_repeated_and_late_samples_are_ignored_silently(order, offset):
    times = [PERIOD * (20 + i + offset) for i in (*order, *order)]
    assignments = assign(times)
    assert {a.problem for a in assignments} == {""}
    used = indices(assignments)
    newest = np.maximum.accumulate([20 + i for i in order])
    assert used == sorted(set(newest.tolist()))


@pytest.mark.parametrize(
    "times",
    [[-0.0051], [1e4], [1.7e9], [5.0, 4.0], [5.0, 6.0], [5.0, 5.01, -1.0], [5.0, 1e9]],
    ids=str,
)
def test_times_of_another_clock_are_refused_with_the_time(times):
    *_, last = assign(times)
    assert last.time is None and last.got == f"{times[-1]:g} s"
    assert last.problem.endswith("expected ascending times in s since the start of the flight")


def test_a_clock_that_is_set_back_is_refused_until_it_catches_up():
    times = PERIOD * np.concatenate([np.arange(100), np.arange(50, 120)])
    assignments = assign(times)
    assert indices(assignments) == list(range(120))
    assert sum(bool(a.problem) for a in assignments) == 40  # The others are late by 10 at most.


@pytest.mark.parametrize("period_s", [0.002, 0.005, 0.008, 0.012, 0.02, 0.05])
def test_another_period_is_reported(period_s):
    assignments = assign(period_s * np.arange(INTERVALS + 1))
    assert {a.problem for a in assignments[:-1]} == {""}
    assert assignments[-1].problem == "expected samples every 0.01 s (rates.sensor_period_s)"
    assert assignments[-1].got == f"every {period_s:g} s; each tick uses the nearest one"
    for assignment, i in zip(assignments, range(INTERVALS + 1), strict=True):
        if assignment.time is not None:
            assert abs(assignment.time - period_s * i) < 0.75 * PERIOD
