"""The learning gate: each rule alone, and arbitrary samples."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.gate import (
    ERROR_FLOOR_M_S,
    FADE_IN,
    FADE_OUT,
    MAX_CORRECTION_M_S,
    MAX_SAMPLE_OFFSET_M_S,
    MIN_IMPROVEMENT,
    REJECTION_RATIO,
    GateCause,
    GateState,
    LearningGate,
    VelocitySample,
)
from aerodrake.scenario import Residual

DT, M = 0.02, 5
SECOND = round(1 / DT)
ZERO = np.zeros(3)
RIGHT = np.array([0.01, -0.005, 0.0])
EXACT = VelocitySample(RIGHT, RIGHT, ZERO)


def make_gate(**changes) -> LearningGate:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return LearningGate(replace(Residual(mode="online"), **changes), theta, DT)


def step(gate: LearningGate, state: GateState, sample: VelocitySample) -> GateState:
    """Returns the state after a tick whose last layer passes its check."""
    state = gate.update(state, sample)
    return gate.apply(state, gate.check_statistics(state), ZERO)


def run(gate: LearningGate, samples, state: GateState | None = None) -> list[GateState]:
    """Returns the state after each sample, from the start or from `state`."""
    state, states = gate.start() if state is None else state, []
    for sample in samples:
        state = step(gate, state, sample)
        states.append(state)
    return states


def is_finite(state: GateState) -> bool:
    return bool(np.isfinite(np.hstack(state)).all())


@pytest.fixture
def used() -> GateState:
    """State in which Delta has always been exact and is fully used."""
    state = run(make_gate(), [EXACT] * 10 * SECOND)[-1]
    assert state.cause == GateCause.OK and state.blend == 1
    return state


@pytest.mark.parametrize("gate_s", [0.2, 1.0, 3.0])
def test_delta_is_used_after_the_time_constant_and_fades_in(gate_s):
    """The mean improvement is a first-order lag from -1; then the ramp."""
    states = run(make_gate(gate_s=gate_s), [EXACT] * 15 * SECOND)
    improvement = RIGHT @ RIGHT / (RIGHT @ RIGHT + ERROR_FLOOR_M_S**2)
    expected_s = gate_s * math.log((1 + improvement) / (improvement - MIN_IMPROVEMENT))
    first = next(k for k, state in enumerate(states) if state.cause == GateCause.OK)
    assert (first + 1) * DT == pytest.approx(expected_s, abs=DT)
    for k, state in enumerate(states):
        assert state.gated_s == pytest.approx((k + 1) * DT if k < first else 0.0)
        ramp = (k + 1 - first) * DT / (FADE_IN * gate_s)
        assert state.blend == pytest.approx(min(1.0, max(0.0, ramp)))


def test_without_a_gate_every_finite_delta_is_used():
    plain = make_gate(gate_s=0.0)
    assert plain.start().blend == 1 and plain.start().cause == GateCause.OK
    harmful = VelocitySample(RIGHT, -9 * RIGHT, RIGHT)
    for state in run(plain, [harmful] * SECOND):
        assert state.blend == 1 and state.gated_s == 0
    assert plain.check_layer(plain.theta_offline + 50.0, np.full(3, 50.0)) == GateCause.OK
    nan = np.full(3, np.nan)
    assert plain.check_layer(plain.theta_offline, nan) == GateCause.NOT_FINITE
    lost = plain.apply(plain.start(), GateCause.NOT_FINITE, RIGHT)
    assert lost.blend == 0 and lost.cause == GateCause.NOT_FINITE
    assert not plain.output(lost, RIGHT).any()
    assert plain.apply(lost, GateCause.OK, ZERO).blend == 1


@pytest.mark.parametrize(
    "sample",
    [
        VelocitySample(RIGHT, ZERO, ZERO),
        VelocitySample(RIGHT, 2.1 * RIGHT, ZERO),
        VelocitySample(RIGHT, -RIGHT, ZERO),
        # The residual is below the floor.
        VelocitySample(np.full(3, 2e-5), np.full(3, 2e-5), ZERO),
    ],
)
def test_delta_that_does_not_improve_the_prediction_is_never_used(sample):
    for state in run(make_gate(), [sample] * 20 * SECOND):
        assert state.blend == 0 and state.cause == GateCause.UNPROVEN


def test_one_large_error_gates_delta_off(used):
    state = step(make_gate(), used, VelocitySample(RIGHT, np.array([0.2, 0.0, 0.0]), ZERO))
    assert state.cause == GateCause.UNHELPFUL and state.blend == 0
    later = run(make_gate(), [EXACT] * 2 * SECOND, state)
    assert later[0].cause == GateCause.UNHELPFUL and later[-1].cause == GateCause.OK
    # The fade-in does not depend on the size of the error.
    assert max(np.diff([state.blend for state in later])) == pytest.approx(DT / FADE_IN)


@pytest.mark.parametrize("cause", [c for c in GateCause if c > GateCause.UNPROVEN])
def test_the_last_delta_fades_out_unless_it_was_harmful(used, cause):
    gate = make_gate()
    state = gate.apply(used, cause, RIGHT)
    for k in range(2 * SECOND):
        left = 0.0 if cause == GateCause.UNHELPFUL else max(0.0, 1 - k * DT / FADE_OUT)
        # The network's current Delta has no effect.
        np.testing.assert_allclose(gate.output(state, 9 * RIGHT), left * RIGHT, atol=1e-12)
        state = gate.apply(state, cause if k < 5 else GateCause.OK, np.full(3, np.inf))


def test_a_label_that_contradicts_the_motion_does_not_enter_the_improvement(used):
    outlier = VelocitySample(np.full(3, 1e9), ZERO, np.full(3, 1e9))
    state = step(make_gate(), used, outlier)
    assert state.mean_benefit == used.mean_benefit
    assert state.mean_improvement == used.mean_improvement
    assert np.linalg.norm(state.mean_offset) <= MAX_SAMPLE_OFFSET_M_S * DT


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e200])
@pytest.mark.parametrize("part", range(3))
def test_non_finite_samples_and_overflowing_squares_are_ignored(used, number, part):
    vectors = [v.copy() for v in EXACT]
    vectors[part][1] = number
    state = make_gate().update(used, VelocitySample(*vectors))
    assert state.mean_benefit == used.mean_benefit
    assert state.mean_improvement == used.mean_improvement
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
    states = run(make_gate(), [VelocitySample(r + offset, r + offset, offset) for r in true])
    for state in states[SECOND:]:
        assert state.cause == GateCause.POISONED and state.blend == 0


@pytest.mark.parametrize("size", [0.004, 0.02, 0.3])
def test_labels_are_rejected_before_delta_is_gated_off(used, size):
    """After less than 0.35 of the time in which they would otherwise be learned."""
    offset = np.array([0.0, 0.0, size])
    states = run(make_gate(), [VelocitySample(RIGHT + offset, RIGHT, offset)] * 3 * SECOND, used)
    rejected = [make_gate().rejects_labels(state) for state in states]
    assert rejected[-1] and not make_gate().rejects_labels(used)
    poisoned = [state.cause == GateCause.POISONED for state in states]
    assert any(poisoned) == (size > make_gate().config.max_offset_m_s)
    if any(poisoned):
        assert rejected.index(True) <= max(0.35 * poisoned.index(True), 0)


def test_poisoning_ends_when_labels_are_consistent_again():
    offset = np.array([0.0, 0.1, 0.0])
    last = run(make_gate(), [VelocitySample(RIGHT, RIGHT, offset)] * 3 * SECOND)[-1]
    healed = run(make_gate(), [EXACT] * 8 * SECOND, last)
    first = next(k for k, state in enumerate(healed) if state.cause == GateCause.OK)
    bound = make_gate().config.max_offset_m_s
    assert np.linalg.norm(healed[first].mean_offset) < bound
    # The mean offset decays to a fraction of its bound, which noise raises.
    assert DT * first < math.log(0.1 / (REJECTION_RATIO * bound))
    assert {state.cause for state in healed[:first]} == {GateCause.POISONED}


@pytest.mark.parametrize("seed", range(3))
def test_position_noise_is_not_poison(seed):
    """2 mm at each sample makes the displacement of a tick wrong by 0.14 m/s."""
    noise = np.random.default_rng(seed).normal(scale=0.002, size=(60 * SECOND + 1, 3))
    offsets = -np.diff(noise, axis=0) / DT
    states = run(make_gate(), [VelocitySample(RIGHT, RIGHT, offset) for offset in offsets])
    assert GateCause.POISONED not in {state.cause for state in states}


@given(
    history=st.lists(st.floats(-3.0, 3.0), max_size=30),
    length=st.integers(1, SECOND),
    large=st.floats(1.0, 30.0),
)
@settings(max_examples=50)
def test_a_wrong_delta_is_gated_off_within_a_second_after_any_history(history, length, large):
    """Wrong: an error four times that without Delta."""
    right = large * RIGHT
    before = [
        VelocitySample(right, ratio * right, ZERO) for ratio in history for _ in range(length)
    ]
    states = run(make_gate(), before + [VelocitySample(RIGHT, 5 * RIGHT, ZERO)] * SECOND)
    assert states[-1].blend == 0 and states[-1].cause != GateCause.OK


VECTOR = arrays(float, 3, elements=st.floats(-1e6, 1e6))


@given(
    samples=st.lists(st.builds(VelocitySample, VECTOR, VECTOR, VECTOR), max_size=40),
    cause=st.sampled_from(GateCause),
    gate_s=st.floats(1e-3, 60.0),
)
def test_delta_is_gated_off_exactly_while_there_is_a_cause(samples, cause, gate_s):
    gate = make_gate(gate_s=gate_s)
    for state in run(gate, samples):
        assert 0 <= state.blend <= 1 and -1 <= state.mean_improvement <= 1 and state.gated_s >= 0
        assert (state.blend > 0) == (state.cause == GateCause.OK)
        assert is_finite(state)
        applied = gate.apply(state, cause, ZERO)
        if cause != GateCause.OK:
            assert applied.blend == 0 and applied.cause == cause


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
