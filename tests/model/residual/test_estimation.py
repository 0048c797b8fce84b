"""Equations of one tick, without Drake: prediction, learning step and reset."""

from collections.abc import Iterator
from copy import deepcopy

import numpy as np
import pytest

from aerodrake.model.residual.estimation import EstimatorInputs, EstimatorState, ResidualEstimation
from aerodrake.model.residual.features import features
from aerodrake.model.residual.gate import GateCause
from aerodrake.model.residual.online_learner import last_layer_step
from aerodrake.model.vehicle.state import split_state
from tests.estimator_flights import JOINTS, equivalent_model, inputs, plain, trained

FIRST, SECOND = (EstimatorInputs(**tick) for tick in inputs(2))
MODEL = equivalent_model()


def make_estimation(mode: str) -> ResidualEstimation:
    network = None if mode == "off" else trained()
    return ResidualEstimation.make(network, MODEL, plain(mode, 0.01, 20))


def applied_input(tick: EstimatorInputs) -> np.ndarray:
    return np.concatenate([tick.base_setpoint[6:], tick.joint_setpoint[2 * JOINTS :]])


def phi(tick: EstimatorInputs) -> np.ndarray:
    return trained().phi(features(tick.state, applied_input(tick)))


def leaves(state: tuple) -> Iterator[np.ndarray | float]:
    """Yields every value of nested tuples."""
    for value in state:
        yield from leaves(value) if isinstance(value, tuple) else (value,)


def assert_equal(state: EstimatorState, expected: EstimatorState):
    for value, wanted in zip(leaves(state), leaves(expected), strict=True):
        np.testing.assert_array_equal(value, wanted)


@pytest.mark.parametrize("mode", ["off", "offline", "online"])
def test_a_tick_compares_the_prediction_of_the_tick_before(mode):
    estimation = make_estimation(mode)
    delta, state = estimation.tick(estimation.start(), FIRST)
    assert state.prediction.is_pending and not state.errors.error.any()
    assert delta.any() == (mode != "off")
    _, state = estimation.tick(state, SECOND)
    u, v_B = applied_input(SECOND), split_state(SECOND.state).v_B
    predicted = MODEL.predict(FIRST.x_0, u, delta)[MODEL.base_velocity]
    np.testing.assert_allclose(state.errors.error, predicted - v_B, atol=1e-12)
    nominal = MODEL.next_velocity(FIRST.x_0, u)
    np.testing.assert_allclose(state.errors.nominal_error, nominal - v_B, atol=1e-12)


def test_the_last_layer_takes_its_step_before_delta_is_inferred():
    estimation = make_estimation("online")
    _, state = estimation.tick(estimation.start(), FIRST)
    delta, state = estimation.tick(state, SECOND)
    target = -state.errors.nominal_error
    c = MODEL.residual_gain
    offline = c[:, None] * trained().last_layer()
    theta = last_layer_step(offline, phi(FIRST)[None], target[None], 0.01)
    np.testing.assert_allclose(state.learner.theta, theta, atol=1e-12)
    np.testing.assert_allclose(delta, theta @ phi(SECOND) / c, atol=1e-12)


@pytest.mark.parametrize("mode", ["offline", "online"])
def test_the_integral_model_has_no_residual(mode):
    """Its labels are undefined: nothing is learned, Delta is zero and counts as used."""
    estimation = ResidualEstimation.make(trained(), equivalent_model("integral"), plain(mode, 1, 2))
    state = estimation.start()
    for tick in (FIRST, SECOND):
        delta, state = estimation.tick(state, tick)
        assert not delta.any()
    assert state.learner.sample_count == 0 and state.gate.layers.learned.cause == GateCause.OK
    np.testing.assert_array_equal(state.errors.error, state.errors.nominal_error)
    assert state.errors.error.any()


def test_a_tick_that_is_not_finite_discards_the_pending_prediction_alone():
    estimation = make_estimation("online")
    _, before = estimation.tick(estimation.start(), FIRST)
    bad = SECOND._replace(x_0=np.full_like(SECOND.x_0, np.nan))
    delta, state = estimation.tick(before, bad)
    assert not delta.any() and not state.prediction.is_pending
    assert_equal(state._replace(prediction=state.prediction._replace(is_pending=True)), before)


def test_arguments_are_not_changed():
    estimation = make_estimation("online")
    _, state = estimation.tick(estimation.start(), FIRST)
    copy = deepcopy(state)
    estimation.tick(state, SECOND)
    assert_equal(state, copy)
