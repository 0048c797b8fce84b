"""The learning gate: the choice between both layers, and the checks of a layer."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.residual.delta_blend import DeltaSource, PerLayer
from aerodrake.model.residual.gate import (
    MAX_CORRECTION_M_S,
    MAX_DISADVANTAGE,
)
from aerodrake.model.residual.layer_gate import (
    GateCause,
)
from tests.gates import (
    RIGHT,
    SECOND,
    ZERO,
    M,
    cause,
    is_finite,
    learned,
    make_gate,
    run,
    sample,
)

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
