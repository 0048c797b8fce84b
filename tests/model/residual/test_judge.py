"""The judge's rules, one by one and against whatever comes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.judge import (
    DOUBTFUL,
    FADE,
    FLOOR_M_S,
    HELPFUL,
    MOST_DELTA_M_S,
    OUTLIER_M_S,
    RAMP,
    Cause,
    Evidence,
    Health,
    LearnerJudge,
)
from aerodrake.scenario import Residual

DT, M = 0.02, 5
SECOND = round(1 / DT)
NONE = np.zeros(3)
RIGHT = np.array([0.01, -0.005, 0.0])
GOOD = Evidence(RIGHT, RIGHT, NONE)


def judge(**changes) -> LearnerJudge:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return LearnerJudge(replace(Residual(mode="online"), **changes), theta, DT)


def after(of: LearnerJudge, health: Health, evidence: Evidence) -> Health:
    """A tick with nothing wrong with the last layer."""
    health = of.weigh(health, evidence)
    return of.rule(health, of.verdict(health), NONE)


def flown(of: LearnerJudge, evidence, health: Health | None = None) -> list[Health]:
    """At each tick, from the start or from `health`."""
    health, found = of.start() if health is None else health, []
    for sample in evidence:
        health = after(of, health, sample)
        found.append(health)
    return found


@pytest.fixture
def used() -> Health:
    """All of Delta, which has always been right."""
    health = flown(judge(), [GOOD] * 10 * SECOND)[-1]
    assert health.cause == Cause.OK and health.share == 1
    return health


@pytest.mark.parametrize("judge_s", [0.2, 1.0, 3.0])
def test_delta_is_used_once_it_has_helped_for_so_long(judge_s):
    """A first-order mean from -1 towards the gain of one that is right; then the ramp."""
    found = flown(judge(judge_s=judge_s), [GOOD] * 15 * SECOND)
    gain = RIGHT @ RIGHT / (RIGHT @ RIGHT + FLOOR_M_S**2)
    expected_s = judge_s * math.log((1 + gain) / (gain - HELPFUL))
    first = next(k for k, health in enumerate(found) if health.cause == Cause.OK)
    assert (first + 1) * DT == pytest.approx(expected_s, abs=DT)
    for k, health in enumerate(found):
        assert health.held_s == pytest.approx((k + 1) * DT if k < first else 0.0)
        ramp = (k + 1 - first) * DT / (RAMP * judge_s)
        assert health.share == pytest.approx(min(1.0, max(0.0, ramp)))


def test_without_a_judge_all_that_is_finite_is_used():
    plain = judge(judge_s=0.0)
    assert plain.start().share == 1 and plain.start().cause == Cause.OK
    harmful = Evidence(RIGHT, -9 * RIGHT, RIGHT)
    for health in flown(plain, [harmful] * SECOND):
        assert health.share == 1 and health.held_s == 0
    assert plain.inspect(plain.theta_offline + 50.0, np.full(3, 50.0)) == Cause.OK
    assert plain.inspect(plain.theta_offline, np.full(3, np.nan)) == Cause.NOT_FINITE
    lost = plain.rule(plain.start(), Cause.NOT_FINITE, RIGHT)
    assert lost.share == 0 and lost.cause == Cause.NOT_FINITE
    assert not plain.used(lost, RIGHT).any()
    assert plain.rule(lost, Cause.OK, NONE).share == 1


@pytest.mark.parametrize(
    "evidence",
    [
        Evidence(RIGHT, NONE, NONE),
        Evidence(RIGHT, 2.1 * RIGHT, NONE),
        Evidence(RIGHT, -RIGHT, NONE),
        Evidence(np.full(3, 2e-5), np.full(3, 2e-5), NONE),  # Nothing to help with.
    ],
)
def test_what_does_not_help_is_never_used(evidence):
    for health in flown(judge(), [evidence] * 20 * SECOND):
        assert health.share == 0 and health.cause == Cause.UNPROVEN


def test_one_large_error_is_enough(used):
    health = after(judge(), used, Evidence(RIGHT, np.array([0.2, 0.0, 0.0]), NONE))
    assert health.cause == Cause.UNHELPFUL and health.share == 0
    again = flown(judge(), [GOOD] * 2 * SECOND, health)
    assert again[0].cause == Cause.UNHELPFUL and again[-1].cause == Cause.OK
    # It returns slowly, however large the error was.
    assert max(np.diff([health.share for health in again])) == pytest.approx(DT / RAMP)


@pytest.mark.parametrize("cause", [c for c in Cause if c > Cause.UNPROVEN])
def test_the_last_sound_delta_fades_and_one_that_did_harm_is_gone(used, cause):
    of = judge()
    health = of.rule(used, cause, RIGHT)
    for k in range(2 * SECOND):
        left = 0.0 if cause == Cause.UNHELPFUL else max(0.0, 1 - k * DT / FADE)
        # Whatever the network says meanwhile.
        np.testing.assert_allclose(of.used(health, 9 * RIGHT), left * RIGHT, atol=1e-12)
        health = of.rule(health, cause if k < 5 else Cause.OK, np.full(3, np.inf))


def test_a_label_that_contradicts_the_motion_counts_neither_for_nor_against(used):
    wild = Evidence(np.full(3, 1e9), NONE, np.full(3, 1e9))
    health = after(judge(), used, wild)
    assert (health.benefit, health.gain) == (used.benefit, used.gain)
    assert np.linalg.norm(health.offset) <= OUTLIER_M_S * DT


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("part", range(3))
def test_what_is_not_finite_leaves_no_trace(used, number, part):
    """Squares that overflow neither."""
    vectors = [v.copy() for v in GOOD]
    vectors[part][1] = number
    health = judge().weigh(used, Evidence(*vectors))
    assert (health.benefit, health.gain) == (used.benefit, used.gain)
    assert np.isfinite(health.to_vector()).all()


@given(
    true=arrays(float, (2 * SECOND, 3), elements=st.floats(-0.1, 0.1)),
    axis=st.integers(0, 2),
    size=st.floats(0.02, 1e3),
    sign=st.sampled_from([-1, 1]),
)
@settings(max_examples=50)
def test_labels_that_are_off_are_found_out_within_a_second(true, axis, size, sign):
    """Whatever the motion, and though Delta is what they say it is to be."""
    offset = sign * size * np.eye(3)[axis]
    found = flown(judge(), [Evidence(r + offset, r + offset, offset) for r in true])
    for health in found[SECOND:]:
        assert health.cause == Cause.POISONED and health.share == 0


@pytest.mark.parametrize("size", [0.004, 0.02, 0.3])
def test_doubts_come_before_the_verdict(used, size):
    """After an error less than a third of what is learned until then otherwise."""
    offset = np.array([0.0, 0.0, size])
    found = flown(judge(), [Evidence(RIGHT + offset, RIGHT, offset)] * 3 * SECOND, used)
    doubts = [judge().doubts(health) for health in found]
    assert doubts[-1] and not judge().doubts(used)
    poisoned = [health.cause == Cause.POISONED for health in found]
    assert any(poisoned) == (size > judge().config.max_offset_m_s)
    if any(poisoned):
        assert doubts.index(True) <= max(0.35 * poisoned.index(True), 0)


def test_a_poisoning_is_over_when_labels_are_right_again():
    offset = np.array([0.0, 0.1, 0.0])
    last = flown(judge(), [Evidence(RIGHT, RIGHT, offset)] * 3 * SECOND)[-1]
    healed = flown(judge(), [GOOD] * 8 * SECOND, last)
    first = next(k for k, health in enumerate(healed) if health.cause == Cause.OK)
    assert np.linalg.norm(healed[first].offset) < judge().config.max_offset_m_s
    # The mean offset decays to a share of what is too much, of which noise explains some.
    assert DT * first < math.log(0.1 / (DOUBTFUL * judge().config.max_offset_m_s))
    assert {health.cause for health in healed[:first]} == {Cause.POISONED}


@pytest.mark.parametrize("seed", range(3))
def test_noise_of_position_is_no_poison(seed):
    """2 mm at each sample, from which the displacement of a tick is off by 0.14 m/s."""
    noise = np.random.default_rng(seed).normal(scale=0.002, size=(60 * SECOND + 1, 3))
    offsets = -np.diff(noise, axis=0) / DT
    found = flown(judge(), [Evidence(RIGHT, RIGHT, offset) for offset in offsets])
    assert Cause.POISONED not in {health.cause for health in found}


@given(
    history=st.lists(st.floats(-3.0, 3.0), max_size=30),
    length=st.integers(1, SECOND),
    large=st.floats(1.0, 30.0),
)
@settings(max_examples=50)
def test_what_goes_wrong_is_given_up_within_a_second_whatever_it_was_before(history, length, large):
    """An error four times that without it."""
    right = large * RIGHT
    before = [Evidence(right, share * right, NONE) for share in history for _ in range(length)]
    found = flown(judge(), before + [Evidence(RIGHT, 5 * RIGHT, NONE)] * SECOND)
    assert found[-1].share == 0 and found[-1].cause != Cause.OK


VECTOR = arrays(float, 3, elements=st.floats(-1e6, 1e6))


@given(
    samples=st.lists(st.builds(Evidence, VECTOR, VECTOR, VECTOR), max_size=40),
    found=st.sampled_from(Cause),
    judge_s=st.floats(1e-3, 60.0),
)
def test_what_is_held_is_zero_and_says_why(samples, found, judge_s):
    of = judge(judge_s=judge_s)
    for health in flown(of, samples):
        assert 0 <= health.share <= 1 and -1 <= health.gain <= 1 and health.held_s >= 0
        assert (health.share > 0) == (health.cause == Cause.OK)
        assert np.isfinite(health.to_vector()).all()
        ruled = of.rule(health, found, NONE)
        if found != Cause.OK:
            assert ruled.share == 0 and ruled.cause == found
        back = Health.from_vector(health.to_vector())
        np.testing.assert_array_equal(back.to_vector(), health.to_vector())


@given(row=st.integers(0, 2), column=st.integers(0, M - 1))
def test_one_number_is_enough_to_be_no_number(row, column):
    of = judge()
    for number in (np.nan, np.inf, -np.inf):
        theta = of.theta_offline.copy()
        theta[row, column] = number
        assert of.inspect(theta, NONE) == Cause.NOT_FINITE


@given(
    away=arrays(float, (3, M), elements=st.floats(-1.0, 1.0)).filter(
        lambda away: np.linalg.norm(away) > 1e-3
    ),
    size=st.floats(0.0, 1e6),
)
def test_a_layer_out_of_its_ball_has_diverged(away, size):
    of = judge(max_drift=0.3)
    theta = of.theta_offline + away * size / np.linalg.norm(away)
    if abs(size - 0.3) > 1e-6:
        expected = Cause.DIVERGED if size > 0.3 else Cause.OK
        assert of.inspect(theta, NONE) == expected
    assert replace(of, config=replace(of.config, max_drift=0.0)).inspect(theta, NONE) == Cause.OK


def test_a_delta_out_of_proportion_has_diverged():
    of = judge(max_drift=0.0)
    for size, expected in ((0.99, Cause.OK), (1.01, Cause.DIVERGED), (1e200, Cause.DIVERGED)):
        delta = np.array([0.0, size * MOST_DELTA_M_S, 0.0])
        assert of.inspect(of.theta_offline, delta) == expected
