"""References: passed on as they are, or held at the last place that can be reached."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.reference.envelope import (
    JUMP_M,
    Envelope,
    ReferenceVerdict,
    accepted,
    judged,
)
from aerodrake.scenario import Supervisor

DT = 0.02
START = np.array([0.0, 0.2, 1.2])
ENVELOPE = Envelope(START, 0.1, 50.0, 1.5)
LAST = np.array([*START, 0.0, 0.0, 0.0])


def ramp(velocity, stages: int = 5) -> np.ndarray:
    """(N + 1, 6) from the start at a velocity."""
    v = np.array(velocity)
    times = DT * np.arange(1, stages + 2)[:, None]
    return np.hstack([START + times * v, np.tile(v, (stages + 1, 1))])


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({}, ReferenceVerdict.OK),
        ({0: np.nan}, ReferenceVerdict.NOT_FINITE),
        ({5: np.inf}, ReferenceVerdict.NOT_FINITE),
        ({2: 0.11}, ReferenceVerdict.OK),
        ({2: 0.09}, ReferenceVerdict.OUT_OF_REACH),
        ({0: 49.0}, ReferenceVerdict.OK),
        ({0: -51.0}, ReferenceVerdict.OUT_OF_REACH),
        ({3: -1.5}, ReferenceVerdict.OK),
        ({4: 1.51}, ReferenceVerdict.TOO_FAST),
        ({5: -1.51}, ReferenceVerdict.TOO_FAST),
    ],
)
def test_what_is_the_matter_with_one(change, verdict):
    row = LAST.copy()
    for place, value in change.items():
        row[place] = value
    assert judged(ENVELOPE, row) == verdict


def test_what_can_be_followed_is_passed_on_to_the_bit():
    rows = ramp([0.7, -0.2, 0.1])
    found, verdict = accepted(ENVELOPE, rows, LAST, LAST, DT)
    np.testing.assert_array_equal(found, rows)
    assert verdict == ReferenceVerdict.OK


@pytest.mark.parametrize("bad", [np.nan, 1e9])
def test_what_cannot_is_held_where_it_was(bad):
    found, verdict = accepted(ENVELOPE, np.full((6, 6), bad), LAST, LAST, DT)
    np.testing.assert_array_equal(found, np.tile(LAST, (6, 1)))
    assert verdict in (ReferenceVerdict.NOT_FINITE, ReferenceVerdict.OUT_OF_REACH)


def test_it_comes_to_rest_before_what_cannot_be_followed():
    rows = ramp([0.7, 0.0, 0.0])
    rows[3:, 2] = -1.0
    found, verdict = accepted(ENVELOPE, rows, LAST, LAST, DT)
    np.testing.assert_array_equal(found[:3], rows[:3])
    np.testing.assert_array_equal(found[3:], np.tile([*rows[2, :3], 0, 0, 0], (3, 1)))
    assert verdict == ReferenceVerdict.OK  # Of now.


@given(st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))
def test_a_jump_is_what_velocity_does_not_explain(offset, speed):
    rows, asked = ramp([speed, 0.0, 0.0]), np.array([*START, speed, 0.0, 0.0])
    rows[:, 1] += offset
    found, verdict = accepted(ENVELOPE, rows, LAST, asked, DT)
    np.testing.assert_array_equal(found, rows)
    assert (verdict == ReferenceVerdict.JUMPED) == (abs(offset) > JUMP_M)


def test_after_numbers_that_were_none_nothing_is_a_jump():
    asked = np.full(6, np.nan)
    assert accepted(ENVELOPE, ramp([0.1, 0, 0]), LAST, asked, DT)[1] == ReferenceVerdict.OK


@given(arrays(float, (6, 6), elements=st.floats(allow_nan=True, allow_infinity=True)))
def test_whatever_comes_what_is_followed_is_within_the_envelope(rows):
    found, _ = accepted(ENVELOPE, rows, LAST, LAST, DT)
    assert all(judged(ENVELOPE, row) == ReferenceVerdict.OK for row in found)


def test_the_envelope_is_the_scenarios():
    envelope = Envelope.make(Supervisor(lowest_m=0.2, farthest_m=3.0, fastest_m_s=0.7), START)
    assert envelope[1:] == (0.2, 3.0, 0.7)
    np.testing.assert_array_equal(envelope.start, START)
