"""An estimator with a gate: a corrupted layer, and clones of its Context."""

import numpy as np

from aerodrake.model.residual.gate import GateCause
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.scenario import Residual
from aerodrake.systems.residual_estimator import ResidualEstimator
from tests.estimator_flights import (
    JOINTS,
    assert_same,
    drive,
    equivalent_model,
    health,
    inputs,
    steady,
)


def make_estimator() -> ResidualEstimator:
    config = Residual(mode="online", learning_rate=0.005, gate_s=0.2)
    return ResidualEstimator(ResidualNetwork.untrained(JOINTS, 0), equivalent_model(), config)


def test_one_entry_of_the_state_that_is_nan_gates_delta_off():
    estimator = make_estimator()
    context = estimator.CreateDefaultContext()
    drive(estimator, context, steady(200))
    assert health(estimator, context) == (GateCause.OK, 0.0)
    group = estimator.groups.learner.groups["theta"]
    theta = context.get_discrete_state(group).value().copy()
    theta[40] = np.nan
    context.SetDiscreteState(group, theta)
    log = drive(estimator, context, steady(202)[200:201])
    assert all(np.isfinite(values).all() for values in log.values())
    assert health(estimator, context)[0] == GateCause.NOT_FINITE
    assert np.isfinite(estimator.groups.learner.read(context).theta).all()


def test_clones_agree():
    estimator = make_estimator()
    context = estimator.CreateDefaultContext()
    drive(estimator, context, steady(200))
    clone = context.Clone()
    assert_same(drive(estimator, clone, inputs(40)), drive(estimator, context, inputs(40)))
    assert context.num_discrete_state_groups() == clone.num_discrete_state_groups()
    for group in range(context.num_discrete_state_groups()):
        np.testing.assert_array_equal(
            clone.get_discrete_state(group).value(), context.get_discrete_state(group).value()
        )
