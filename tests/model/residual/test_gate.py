"""The learning gate: each rule alone, and arbitrary samples."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.delta_blend import FADE_IN, DeltaSource, PerLayer
from aerodrake.model.residual.gate import (
    MAX_CORRECTION_M_S,
    MAX_DISADVANTAGE,
    MAX_SAMPLE_OFFSET_M_S,
    REJECTION_RATIO,
    GateState,
    LearningGate,
    VelocitySample,
)
from aerodrake.model.residual.layer_gate import (
    ERROR_FLOOR_M_S,
    MIN_IMPROVEMENT,
    GateCause,
    LayerState,
)
from aerodrake.scenario import Residual

DT, M = 0.02, 5
SECOND = round(1 / DT)
ZERO = np.zeros(3)
FINE = PerLayer(GateCause.OK, GateCause.OK)
RIGHT = np.array([0.01, -0.005, 0.0])


def sample(target, learned, offset=ZERO, offline=None) -> VelocitySample:
    """Returns a sample; by default the offline layer is wrong, and never used."""
    offline = -3 * target if offline is None else offline
    return VelocitySample(target, PerLayer(offline, learned), offset)


EXACT = sample(RIGHT, RIGHT)


def make_gate(**changes) -> LearningGate:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return LearningGate(replace(Residual(mode="online"), **changes), theta, DT)


def step(gate: LearningGate, state: GateState, one: VelocitySample) -> GateState:
    """Returns the state after a tick whose last layers pass their check."""
    state = gate.update(state, one)
    return gate.apply(state, gate.check_statistics(state), PerLayer(ZERO, ZERO), ZERO)[1]


def run(gate: LearningGate, samples, state: GateState | None = None) -> list[GateState]:
    """Returns the state after each sample, from the start or from `state`."""
    state, states = gate.start() if state is None else state, []
    for one in samples:
        state = step(gate, state, one)
        states.append(state)
    return states


def learned(state: GateState) -> LayerState:
    return state.layers.learned


def cause(state: GateState) -> GateCause:
    """Returns the learned layer's."""
    return state.layers.learned.cause


def weight(state: GateState) -> float:
    """Returns the learned layer's."""
    return state.blend.weights.learned


def is_finite(state: tuple) -> bool:
    return all(is_finite(v) if isinstance(v, tuple) else np.isfinite(v).all() for v in state)


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


VECTOR = arrays(float, 3, elements=st.floats(-1e6, 1e6))


CAUSES = st.builds(PerLayer, st.sampled_from(GateCause), st.sampled_from(GateCause))


@given(
    samples=st.lists(st.builds(sample, VECTOR, VECTOR, VECTOR, VECTOR), max_size=40),
    causes=CAUSES,
    gate_s=st.floats(1e-3, 60.0),
    mode=st.sampled_from(["offline", "online"]),
)
def test_the_best_layer_without_a_cause_is_used(samples, causes, gate_s, mode):
    gate = make_gate(gate_s=gate_s, mode=mode)
    for state in run(gate, samples):
        _, applied = gate.apply(state, causes, PerLayer(ZERO, ZERO), ZERO)
        for now in (state, applied):
            assert is_finite(now)
            for layer in now.layers:
                assert -1 <= layer.mean_improvement <= 1 and layer.gated_s >= 0
            is_used = [layer.cause == GateCause.OK for layer in now.layers]
            expected = DeltaSource.OFFLINE if is_used[0] else DeltaSource.NONE
            if is_used[1] and mode == "online":
                expected = DeltaSource.LEARNED
            assert now.blend.source == expected
            assert all(0 <= weight <= 1 for weight in now.blend.weights)
        for layer, reason in zip(applied.layers, causes, strict=True):
            assert reason in (GateCause.OK, layer.cause)


# Both layers: the learned one, else the offline one, else none.

WRONG = 3 * RIGHT


@pytest.mark.parametrize(
    ("learned_correction", "offline_correction", "source"),
    [
        (RIGHT, 0.7 * RIGHT, DeltaSource.LEARNED),
        (0.7 * RIGHT, 0.7 * RIGHT, DeltaSource.LEARNED),  # As after a restart.
        (0.7 * RIGHT, RIGHT, DeltaSource.OFFLINE),  # Good, but worse than the offline layer.
        (0.7 * RIGHT, WRONG, DeltaSource.LEARNED),
        (WRONG, 0.7 * RIGHT, DeltaSource.OFFLINE),
        (WRONG, WRONG, DeltaSource.NONE),
    ],
)
def test_the_best_proven_layer_is_used(learned_correction, offline_correction, source):
    one = sample(RIGHT, learned_correction, offline=offline_correction)
    assert run(make_gate(), [one] * 10 * SECOND)[-1].blend.source == source
    offline = run(make_gate(mode="offline"), [one] * 10 * SECOND)[-1].blend.source
    is_wrong = offline_correction is WRONG
    assert offline == (DeltaSource.NONE if is_wrong else DeltaSource.OFFLINE)


def test_the_offline_layer_takes_over_from_a_learned_one_that_falls_behind():
    """The learned layer still improves the prediction: its error is half that without Delta."""
    gate, good = make_gate(), sample(RIGHT, RIGHT, offline=0.9 * RIGHT)
    state = run(gate, [good] * 10 * SECOND)[-1]
    assert state.blend.source == DeltaSource.LEARNED
    behind = sample(RIGHT, 0.5 * RIGHT, offline=0.9 * RIGHT)
    states = run(gate, [behind] * 5 * SECOND, state)
    left = next(k for k, s in enumerate(states) if s.blend.source == DeltaSource.OFFLINE)
    assert cause(states[left]) == GateCause.UNHELPFUL and learned(states[left - 1]).mean_benefit > 0
    assert states[left - 1].mean_advantage >= -MAX_DISADVANTAGE
    assert states[-1].blend.source == DeltaSource.OFFLINE


def test_poison_is_of_the_learned_layer_alone():
    """The offline layer stays in use, since a constant offset is removed from the labels."""
    offset = np.array([0.0, 0.006, 0.0])
    good = sample(RIGHT, RIGHT, offline=0.9 * RIGHT)
    state = run(make_gate(max_offset_m_s=0.002), [good] * 10 * SECOND)[-1]
    bad = sample(RIGHT + offset, RIGHT, offset, offline=0.9 * RIGHT)
    states = run(make_gate(max_offset_m_s=0.002), [bad] * 10 * SECOND, state)
    assert cause(states[-1]) == GateCause.POISONED
    assert states[-1].blend.source == DeltaSource.OFFLINE


@given(row=st.integers(0, 2), column=st.integers(0, M - 1))
def test_one_entry_makes_a_layer_not_finite(row, column):
    gate = make_gate()
    for number in (np.nan, np.inf, -np.inf):
        theta = gate.theta_offline.copy()
        theta[row, column] = number
        assert gate.check_layer(theta, ZERO) == GateCause.NOT_FINITE


@given(
    direction=arrays(float, (3, M), elements=st.floats(-1.0, 1.0)).filter(
        lambda direction: np.linalg.norm(direction) > 1e-3
    ),
    size=st.floats(0.0, 1e6),
)
def test_a_layer_outside_its_ball_has_diverged(direction, size):
    gate = make_gate(max_drift=0.3)
    theta = gate.theta_offline + direction * size / np.linalg.norm(direction)
    if abs(size - 0.3) > 1e-6:
        expected = GateCause.DIVERGED if size > 0.3 else GateCause.OK
        assert gate.check_layer(theta, ZERO) == expected
    unbounded = replace(gate, config=replace(gate.config, max_drift=0.0))
    assert unbounded.check_layer(theta, ZERO) == GateCause.OK


def test_an_implausible_delta_has_diverged():
    gate = make_gate(max_drift=0.0)
    for size, expected in (
        (0.99, GateCause.OK),
        (1.01, GateCause.DIVERGED),
        (1e200, GateCause.DIVERGED),
    ):
        correction = np.array([0.0, size * MAX_CORRECTION_M_S, 0.0])
        assert gate.check_layer(gate.theta_offline, correction) == expected
