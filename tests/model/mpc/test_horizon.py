"""The stages of the horizon, for any number of them and any span."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st

from aerodrake.model.mpc.horizon import stage_ticks
from aerodrake.scenario import Mpc


@given(st.integers(2, 200), st.integers(1, 1000))
@example(2, 1000)
@example(200, 201)
@example(15, 15)
def test_stages_grow_from_one_tick_and_fill_the_span(horizon, span):
    ticks = stage_ticks(Mpc(horizon=horizon, span_ticks=span))
    assert ticks.shape == (horizon,) and ticks.dtype.kind == "i"
    assert ticks[0] == 1
    assert np.all(np.diff(ticks) >= 0)
    assert ticks.sum() == max(span, horizon)
    if span <= horizon:
        np.testing.assert_array_equal(ticks, 1)


@given(st.integers(3, 40), st.floats(1.1, 1.6))
def test_stages_grow_in_proportion(horizon, ratio):
    """But for their rounding to ticks: those of an exact progression are met."""
    exact = ratio ** np.arange(horizon)
    ends = np.cumsum(exact)
    span = round(ends[-1])
    ticks = stage_ticks(Mpc(horizon=horizon, span_ticks=span))
    # An end is rounded to half a tick, and pushed on while stages of less than one grow to it.
    assert np.abs(np.cumsum(ticks) / ends - 1).max() < 0.5
    assert np.abs(ticks[-1] / exact[-1] - 1) < max(0.1, 1.5 / exact[-1])


def test_the_default_reaches_two_seconds_ahead_and_looks_closest_at_what_is_near():
    ticks = stage_ticks(Mpc())
    assert len(ticks) == 15 and ticks.sum() == 100
    assert ticks[:4].max() <= 3 and 15 <= ticks[-1] <= 25
