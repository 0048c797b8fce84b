"""The learning gate: each rule of the learned layer alone."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.delta_blend import FADE_IN, DeltaSource, PerLayer
from aerodrake.model.residual.gate import (
    MAX_SAMPLE_OFFSET_M_S,
    REJECTION_RATIO,
    GateState,
)
from aerodrake.model.residual.layer_gate import (
    ERROR_FLOOR_M_S,
    MIN_IMPROVEMENT,
    GateCause,
)
from tests.gates import (
    DT,
    EXACT,
    FINE,
    RIGHT,
    SECOND,
    ZERO,
    cause,
    is_finite,
    learned,
    make_gate,
    run,
    sample,
    step,
    weight,
)


@pytest.fixture
def used() -> GateState:
    """State in which Delta has always been exact and is fully used."""
    state = run(make_gate(), [EXACT] * 10 * SECOND)[-1]
    assert cause(state) == GateCause.OK and weight(state) == 1
    return state


@pytest.mark.parametrize("gate_s", [0.2, 1.0, 3.0])
def test_delta_is_used_after_the_time_constant_and_fades_in(gate_s):
    """The mean improvement is a first-order lag from -1; then the ramp."""
    states = run(make_gate(gate_s=gate_s), [EXACT] * 15 * SECOND)
    improvement = RIGHT @ RIGHT / (RIGHT @ RIGHT + ERROR_FLOOR_M_S**2)
    expected_s = gate_s * math.log((1 + improvement) / (improvement - MIN_IMPROVEMENT))
    first = next(k for k, state in enumerate(states) if cause(state) == GateCause.OK)
    assert (first + 1) * DT == pytest.approx(expected_s, abs=DT)
    for k, state in enumerate(states):
        assert learned(state).gated_s == pytest.approx((k + 1) * DT if k < first else 0.0)
        ramp = (k + 1 - first) * DT / (FADE_IN * gate_s)
        assert weight(state) == pytest.approx(min(1.0, max(0.0, ramp)))


def test_without_a_gate_every_finite_delta_is_used():
    plain = make_gate(gate_s=0.0)
    assert weight(plain.start()) == 1 and cause(plain.start()) == GateCause.OK
    harmful = sample(RIGHT, -9 * RIGHT, RIGHT)
    for state in run(plain, [harmful] * SECOND):
        assert weight(state) == 1 and learned(state).gated_s == 0
    assert plain.check_layer(plain.theta_offline + 50.0, np.full(3, 50.0)) == GateCause.OK
    nan = np.full(3, np.nan)
    assert plain.check_layer(plain.theta_offline, nan) == GateCause.NOT_FINITE
    corrections = PerLayer(2 * RIGHT, nan)
    for both in (False, True):
        offline = GateCause.NOT_FINITE if both else GateCause.OK
        causes = PerLayer(offline, GateCause.NOT_FINITE)
        correction, lost = plain.apply(plain.start(), causes, corrections, RIGHT)
        np.testing.assert_array_equal(correction, ZERO if both else 2 * RIGHT)
        assert weight(lost) == 0 and cause(lost) == GateCause.NOT_FINITE
        assert weight(plain.apply(lost, FINE, PerLayer(ZERO, ZERO), ZERO)[1]) == 1


@pytest.mark.parametrize(
    ("target", "correction"),
    [
        (RIGHT, ZERO),
        (RIGHT, 2.1 * RIGHT),
        (RIGHT, -RIGHT),
        # The residual is below the floor.
        (np.full(3, 2e-5), np.full(3, 2e-5)),
    ],
)
@pytest.mark.parametrize("mode", ["offline", "online"])
def test_delta_that_does_not_improve_the_prediction_is_never_used(target, correction, mode):
    useless = sample(target, correction, offline=correction)
    for state in run(make_gate(mode=mode), [useless] * 20 * SECOND):
        assert state.blend.source == DeltaSource.NONE and state.blend.weights == (0, 0)
        assert {layer.cause for layer in state.layers} == {GateCause.UNPROVEN}


def test_one_large_error_gates_delta_off(used):
    state = step(make_gate(), used, sample(RIGHT, np.array([0.2, 0.0, 0.0])))
    assert cause(state) == GateCause.UNHELPFUL and weight(state) == 0
    later = run(make_gate(), [EXACT] * 2 * SECOND, state)
    assert cause(later[0]) == GateCause.UNHELPFUL and cause(later[-1]) == GateCause.OK
    # The fade-in does not depend on the size of the error.
    assert max(np.diff([weight(state) for state in later])) == pytest.approx(DT / FADE_IN)


def test_a_label_that_contradicts_the_motion_does_not_enter_the_improvement(used):
    outlier = sample(np.full(3, 1e9), ZERO, np.full(3, 1e9))
    state = step(make_gate(), used, outlier)
    assert learned(state)[2:] == learned(used)[2:]
    assert state.layers.offline.mean_benefit == used.layers.offline.mean_benefit
    assert np.linalg.norm(state.mean_offset) <= MAX_SAMPLE_OFFSET_M_S * DT


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("part", range(3))
def test_non_finite_samples_and_overflowing_squares_are_ignored(used, number, part):
    vectors = [v.copy() for v in (RIGHT, RIGHT, ZERO)]
    vectors[part][1] = number
    state = make_gate().update(used, sample(*vectors))
    assert learned(state) == learned(used) and state.mean_advantage == used.mean_advantage
    assert is_finite(state)


@given(
    true=arrays(float, (2 * SECOND, 3), elements=st.floats(-0.1, 0.1)),
    axis=st.integers(0, 2),
    size=st.floats(0.02, 1e3),
    sign=st.sampled_from([-1, 1]),
)
@settings(max_examples=50)
def test_offset_labels_are_detected_within_a_second(true, axis, size, sign):
    """For any motion, and although Delta predicts the labels exactly."""
    offset = sign * size * np.eye(3)[axis]
    states = run(make_gate(), [sample(r + offset, r + offset, offset) for r in true])
    for state in states[SECOND:]:
        assert cause(state) == GateCause.POISONED and weight(state) == 0


@pytest.mark.parametrize("size", [0.004, 0.02, 0.3])
def test_labels_are_rejected_before_delta_is_gated_off(used, size):
    """After less than 0.35 of the time in which they would otherwise be learned."""
    offset = np.array([0.0, 0.0, size])
    states = run(make_gate(), [sample(RIGHT + offset, RIGHT, offset)] * 3 * SECOND, used)
    rejected = [make_gate().rejects_labels(state) for state in states]
    assert rejected[-1] and not make_gate().rejects_labels(used)
    poisoned = [cause(state) == GateCause.POISONED for state in states]
    assert any(poisoned) == (size > make_gate().config.max_offset_m_s)
    if any(poisoned):
        assert rejected.index(True) <= max(0.35 * poisoned.index(True), 0)


def test_poisoning_ends_when_labels_are_consistent_again():
    offset = np.array([0.0, 0.1, 0.0])
    last = run(make_gate(), [sample(RIGHT, RIGHT, offset)] * 3 * SECOND)[-1]
    healed = run(make_gate(), [EXACT] * 8 * SECOND, last)
    first = next(k for k, state in enumerate(healed) if cause(state) == GateCause.OK)
    bound = make_gate().config.max_offset_m_s
    assert np.linalg.norm(healed[first].mean_offset) < bound
    # The mean offset decays to a fraction of its bound, which noise raises.
    assert DT * first < math.log(0.1 / (REJECTION_RATIO * bound))
    assert set(map(cause, healed[:first])) == {GateCause.POISONED}


@pytest.mark.parametrize("seed", range(3))
def test_position_noise_is_not_poison(seed):
    """2 mm at each sample makes the displacement of a tick wrong by 0.14 m/s."""
    noise = np.random.default_rng(seed).normal(scale=0.002, size=(60 * SECOND + 1, 3))
    offsets = -np.diff(noise, axis=0) / DT
    states = run(make_gate(), [sample(RIGHT, RIGHT, offset) for offset in offsets])
    assert GateCause.POISONED not in set(map(cause, states))


@given(
    history=st.lists(st.floats(-3.0, 3.0), max_size=30),
    length=st.integers(1, SECOND),
    large=st.floats(1.0, 30.0),
)
@settings(max_examples=50)
def test_a_wrong_delta_is_gated_off_within_a_second_after_any_history(history, length, large):
    """Wrong: an error four times that without Delta."""
    right = large * RIGHT
    before = [sample(right, ratio * right) for ratio in history for _ in range(length)]
    states = run(make_gate(), before + [sample(RIGHT, 5 * RIGHT)] * SECOND)
    assert weight(states[-1]) == 0 and cause(states[-1]) != GateCause.OK
