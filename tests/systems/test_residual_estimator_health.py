"""An estimator whose learner is judged: what is lost, poisoned or wrong, and what becomes of it."""

import numpy as np
import pytest
from pydrake.systems.framework import Context

from aerodrake.model.residual.judge import Cause
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Residual
from aerodrake.systems.residual_estimator import ResidualEstimator
from tests.estimator_flights import (
    DT,
    JOINTS,
    OUTPUTS,
    assert_same,
    drive,
    equivalent_model,
    fly,
    inputs,
    plain,
    trained,
)


def steady(ticks: int) -> list[dict[str, np.ndarray]]:
    """At rest on its setpoint, but for a residual that the untrained network can learn."""
    flight = inputs(1)[0] | {"saturated": np.zeros(1), "x_0": np.zeros(12 + 2 * JOINTS)}
    velocity = split_state(flight["state"]).v_B
    velocity[:] = 0.10, -0.05, 0.02
    flight["base_setpoint"] *= 0
    found = []
    for k in range(ticks):  # The base goes where its velocity takes it.
        state = flight["state"].copy()
        split_state(state).p_B[:] = k * DT * velocity
        found.append(flight | {"state": state})
    return found


def judged() -> tuple[ResidualEstimator, Context]:
    """Of an untrained network that learns fast, and has been heard for long."""
    config = Residual(mode="online", learning_rate=0.005, judge_s=0.2)
    estimator = ResidualEstimator(ResidualNetwork.untrained(JOINTS, 0), equivalent_model(), config)
    context = estimator.CreateDefaultContext()
    log = drive(estimator, context, steady(200))
    assert np.all(log["delta"][0] == 0) and np.all(log["delta"][-1] != 0)
    return estimator, context


def health(estimator: ResidualEstimator, context: Context) -> tuple[Cause, float]:
    cause, held_s = estimator.GetOutputPort("learner_health").Eval(context)
    return Cause(int(cause)), held_s


@pytest.mark.parametrize(
    ("theta", "cause"),
    [(np.nan, Cause.NOT_FINITE), (-np.inf, Cause.NOT_FINITE), (1e6, Cause.DIVERGED)],
)
def test_a_layer_that_is_lost_is_never_heard_and_begins_again(theta, cause):
    estimator, context = judged()
    assert health(estimator, context) == (Cause.OK, 0.0)
    port = estimator.GetInputPort("fault")
    port.FixValue(context, [theta, 0.0, 0.0, 0.0])
    last = drive(estimator, context.Clone(), steady(200)[199:])["delta"][0]
    at_first = drive(estimator, context, steady(202)[200:201])["delta"][0]
    np.testing.assert_allclose(at_first, last, atol=1e-3)  # It goes slowly.
    assert health(estimator, context) == (cause, 0.0)
    for group in range(4):  # The layer as it was trained, here at zero, and an empty ring.
        assert not context.get_discrete_state(group).value().any()

    port.FixValue(context, np.zeros(4))
    delta = drive(estimator, context, steady(400)[201:])["delta"]
    zero = np.flatnonzero(~delta.any(axis=1))  # After 0.1 s, until it has helped for 0.2 s.
    assert zero[0] == 4 and np.all(np.diff(zero) == 1) and zero[-1] < 100
    assert np.all(np.diff(np.abs(delta[:4]), axis=0) < 0)
    assert health(estimator, context) == (Cause.OK, 0.0)


def test_one_number_of_the_layer_is_enough():
    """Lost wherever it stands: in the Context, as a stray write would leave it."""
    estimator, context = judged()
    theta = context.get_discrete_state(0).value().copy()
    theta[40] = np.nan
    context.SetDiscreteState(0, theta)
    log = drive(estimator, context, steady(202)[200:201])
    assert all(np.isfinite(values).all() for values in log.values())
    assert health(estimator, context)[0] == Cause.NOT_FINITE
    assert np.isfinite(context.get_discrete_state(0).value()).all()


def test_poisoned_labels_are_not_learned_once_they_are_known():
    estimator, context = judged()
    estimator.GetInputPort("fault").FixValue(context, [0.0, 0.0, 0.3, 0.0])
    delta = drive(estimator, context, steady(230)[200:])["delta"]
    assert not delta[-20:].any()
    assert health(estimator, context)[0] == Cause.POISONED
    assert not context.get_discrete_state(0).value().any()


def test_what_is_wrong_is_wrong_with_the_label_alone():
    """Nothing that the network sees; its prediction stands as it was."""
    estimator = ResidualEstimator(trained(), equivalent_model(), plain("offline", 0.01, 20))
    context, offset = estimator.CreateDefaultContext(), np.array([0.1, -0.2, 0.3])
    estimator.GetInputPort("fault").FixValue(context, [0.0, *offset])
    log = drive(estimator, context, inputs(10))
    clean = fly(trained(), equivalent_model(), "offline", 0.01, 20, inputs(10))
    np.testing.assert_array_equal(log["delta"], clean["delta"])
    for name in OUTPUTS[1:]:
        np.testing.assert_allclose(log[name][1:], clean[name][1:] - offset, atol=1e-12)


def test_clones_of_a_judge_agree():
    estimator, context = judged()
    clone = context.Clone()
    assert_same(drive(estimator, clone, inputs(40)), drive(estimator, context, inputs(40)))
    assert context.num_discrete_state_groups() == clone.num_discrete_state_groups()
    for group in range(context.num_discrete_state_groups()):
        np.testing.assert_array_equal(
            clone.get_discrete_state(group).value(), context.get_discrete_state(group).value()
        )
