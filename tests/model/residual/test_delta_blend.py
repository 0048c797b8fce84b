"""The blend of the layers' Delta: ramps, fades, and no steps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.residual.delta_blend import (
    FADE_IN,
    FADE_OUT,
    FADE_OUT_UNHELPFUL,
    DeltaBlend,
    DeltaSource,
    PerLayer,
)

DT = 0.02
BLEND = DeltaBlend(1.0, DT)
OFFLINE, LEARNED = np.array([0.004, 0.008, 0.0]), np.array([0.0, 0.008, -0.004])
BOTH = PerLayer(OFFLINE, LEARNED)
NAN = PerLayer(np.full(3, np.nan), np.full(3, np.nan))


def run(sources, *, is_harmful=False, start=DeltaSource.NONE, corrections=BOTH, blend=BLEND):
    """Returns c Delta (T, 3) over ticks with the given sources, from the full weight of `start`."""
    state, rows = blend.start(start), [_full(start)]
    for source in sources:
        row, state = blend.step(state, source, is_harmful, corrections, rows[-1])
        rows.append(row)
    return np.array(rows)


def _full(source: DeltaSource) -> np.ndarray:
    return {DeltaSource.LEARNED: LEARNED, DeltaSource.OFFLINE: OFFLINE}.get(source, np.zeros(3))


@pytest.mark.parametrize("source", [DeltaSource.LEARNED, DeltaSource.OFFLINE])
def test_a_layer_ramps_in_from_zero(source):
    rows = run([source] * 150)
    ramp = np.minimum(1.0, np.arange(151) * DT / FADE_IN)
    np.testing.assert_allclose(rows, np.outer(ramp, _full(source)), atol=1e-15)


def test_the_learned_layer_replaces_the_offline_one_by_a_ramp():
    rows = run([DeltaSource.LEARNED] * 150, start=DeltaSource.OFFLINE)
    ramp = np.minimum(1.0, np.arange(151) * DT / FADE_IN)[:, None]
    np.testing.assert_allclose(rows, (1 - ramp) * OFFLINE + ramp * LEARNED, atol=1e-15)


@pytest.mark.parametrize(
    ("source", "is_harmful", "fade_s"),
    [
        (DeltaSource.OFFLINE, False, FADE_OUT),
        (DeltaSource.OFFLINE, True, FADE_OUT_UNHELPFUL),
        (DeltaSource.NONE, False, FADE_OUT),
    ],
)
def test_the_last_delta_fades_out_at_a_change_to_a_worse_source(source, is_harmful, fade_s):
    """The layer that was used has no effect any more; the worse one has its weight at once."""
    base = _full(source)
    corrections = PerLayer(OFFLINE, NAN.learned)
    rows = run([source] * 60, is_harmful=is_harmful, start=DeltaSource.LEARNED,
               corrections=corrections)[1:]  # fmt: skip
    left = np.maximum(0.0, 1 - np.arange(60) * DT / fade_s)
    np.testing.assert_allclose(rows, base + np.outer(left, LEARNED - base), atol=1e-12)
    np.testing.assert_array_equal(rows[30:], np.tile(base, (30, 1)))


@given(sources=st.lists(st.sampled_from(DeltaSource), max_size=80))
def test_no_change_of_the_source_is_a_step(sources):
    """Each tick moves c Delta by at most the fastest fade and ramp of the layers' values."""
    state, last = BLEND.start(DeltaSource.NONE), np.zeros(3)
    largest = 2 * (np.abs(OFFLINE) + np.abs(LEARNED)).max()
    for source in sources:
        now, state = BLEND.step(state, source, False, BOTH, last)
        assert sum(state.weights) <= 1 + 1e-12 and 0 <= state.fade <= 1
        assert np.abs(now - last).max() <= (DT / FADE_OUT + 2 * DT / FADE_IN) * largest
        last = now


def test_a_large_harmful_delta_is_dropped_at_once():
    """What fades out is no longer than the offline layer's; of another cause, all fades out."""
    last = np.array([0.3, 0.0, -0.4])
    state = BLEND.start(DeltaSource.LEARNED)
    now, _ = BLEND.step(state, DeltaSource.OFFLINE, True, BOTH, last)
    part = np.linalg.norm(OFFLINE) / np.linalg.norm(last - OFFLINE)
    np.testing.assert_allclose(now, OFFLINE + part * (last - OFFLINE), rtol=1e-12)
    now, _ = BLEND.step(state, DeltaSource.NONE, True, BOTH, last)
    assert not now.any()
    for source in (DeltaSource.OFFLINE, DeltaSource.NONE):
        now, _ = BLEND.step(state, source, False, BOTH, last)
        np.testing.assert_allclose(now, last, rtol=1e-12)


def test_without_a_time_constant_changes_take_one_tick():
    blend = DeltaBlend(0.0, DT)
    sources = [DeltaSource.LEARNED, DeltaSource.OFFLINE, DeltaSource.NONE, DeltaSource.OFFLINE]
    rows = run(sources, blend=blend)[1:]
    np.testing.assert_array_equal(rows, [_full(source) for source in sources])


def test_layers_without_weight_may_be_nan():
    assert not run([DeltaSource.NONE] * 3, corrections=NAN).any()
