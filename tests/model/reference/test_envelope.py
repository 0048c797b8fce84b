"""Tests of the envelope and of guarded references."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.reference.envelope import (
    JUMP_M,
    Envelope,
    GuardState,
    ReferenceVerdict,
    check_point,
    guard_reference,
)
from aerodrake.scenario import Supervisor

DT = 0.02
START = np.array([0.0, 0.2, 1.2])
ENVELOPE = Envelope(START, 0.1, 50.0, 1.5)
LAST = np.array([*START, 0.0, 0.0, 0.0])
STATE = GuardState(LAST, LAST, 0)


def ramp(velocity, stages: int = 5) -> np.ndarray:
    """Returns a reference (N + 1, 6) from the start at a constant velocity."""
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
def test_verdict_on_a_single_point(change, verdict):
    point = LAST.copy()
    for index, value in change.items():
        point[index] = value
    assert check_point(ENVELOPE, point) == verdict


def test_a_reference_within_the_envelope_is_passed_on_bit_for_bit():
    rows = ramp([0.7, -0.2, 0.1])
    accepted, verdict = guard_reference(ENVELOPE, rows, STATE, DT)
    np.testing.assert_array_equal(accepted, rows)
    assert verdict == ReferenceVerdict.OK


@pytest.mark.parametrize("bad", [np.nan, 1e9])
def test_a_refused_reference_rests_at_the_last_accepted_position(bad):
    accepted, verdict = guard_reference(ENVELOPE, np.full((6, 6), bad), STATE, DT)
    np.testing.assert_array_equal(accepted, np.tile(LAST, (6, 1)))
    assert verdict in (ReferenceVerdict.NOT_FINITE, ReferenceVerdict.OUT_OF_REACH)


def test_rests_before_the_first_stage_outside_the_envelope():
    rows = ramp([0.7, 0.0, 0.0])
    rows[3:, 2] = -1.0
    accepted, verdict = guard_reference(ENVELOPE, rows, STATE, DT)
    np.testing.assert_array_equal(accepted[:3], rows[:3])
    np.testing.assert_array_equal(accepted[3:], np.tile([*rows[2, :3], 0, 0, 0], (3, 1)))
    assert verdict == ReferenceVerdict.OK  # The verdict is on the current point.


@given(st.floats(-0.5, 0.5), st.floats(-1.0, 1.0))
def test_a_jump_is_a_displacement_that_velocity_does_not_explain(offset, speed):
    assume(abs(abs(offset) - JUMP_M) > 1e-9)  # The displacement is that up to rounding.
    rows, requested = ramp([speed, 0.0, 0.0]), np.array([*START, speed, 0.0, 0.0])
    rows[:, 1] += offset
    accepted, verdict = guard_reference(ENVELOPE, rows, GuardState(LAST, requested, 0), DT)
    np.testing.assert_array_equal(accepted, rows)
    assert (verdict == ReferenceVerdict.JUMPED) == (abs(offset) > JUMP_M)


def test_no_jump_is_reported_after_nan():
    state = GuardState(LAST, np.full(6, np.nan), int(ReferenceVerdict.NOT_FINITE))
    assert guard_reference(ENVELOPE, ramp([0.1, 0, 0]), state, DT)[1] == ReferenceVerdict.OK


@given(arrays(float, (6, 6), elements=st.floats(allow_nan=True, allow_infinity=True)))
def test_guarded_references_are_within_the_envelope(rows):
    accepted, _ = guard_reference(ENVELOPE, rows, STATE, DT)
    assert all(check_point(ENVELOPE, row) == ReferenceVerdict.OK for row in accepted)


def test_the_envelope_is_made_from_the_scenario():
    envelope = Envelope.make(Supervisor(lowest_m=0.2, farthest_m=3.0, fastest_m_s=0.7), START)
    assert envelope[1:] == (0.2, 3.0, 0.7)
    np.testing.assert_array_equal(envelope.start, START)
