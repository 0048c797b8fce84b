"""Summaries of the prediction errors, and the methods' predictions."""

import dataclasses

import numpy as np
import pytest

from aerodrake.learning.collection_runs import CollectionRun
from aerodrake.learning.evaluation import METHODS, Candidates, NetworkEvaluation, evaluate
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.scenario import Residual

CALM = CollectionRun("a", "held_out", 1.0, 5.0, 0.0)
WIND, LIGHT = (dataclasses.replace(CALM, name=name, twin="a") for name in ("a_w", "a_l"))


def row(none, offline, online):
    return {"none": none, "offline": offline, "online": online, "linear": 0.0, "ridge": 0.0}


def test_removed_recovered_and_worst_ratios():
    evaluation = NetworkEvaluation(
        [CALM, WIND, LIGHT], [row(10.0, 2.0, 1.0), row(20.0, 22.0, 7.0), row(10.0, 2.1, 1.0)]
    )
    assert evaluation.removed == pytest.approx(0.8)
    assert evaluation.worst == pytest.approx(1.1)
    # The wind adds 20, of which 15 are removed; LIGHT adds less than 10 %.
    assert [evaluation.recovered(i) for i in range(3)] == [None, pytest.approx(0.75), None]
    assert evaluation.least_recovered == pytest.approx(0.75)
    assert evaluation.as_mapping()["recovered"] == {"a_w": pytest.approx(0.75), "a_l": None}


def test_errors_of_every_method():
    generator = np.random.default_rng(0)
    features = 0.1 * generator.normal(size=(400, 30))
    targets = features[:, 3:6] + [0.03, 0.0, 0.0]
    network = ResidualNetwork.untrained(6, seed=0)
    fit = LinearResidual.fit([(features, targets)], 0.0)
    residual = Residual(learning_rate=0.02, max_step=0.0, max_drift=0.0)
    learner = OnlineLearner(residual, network.last_layer())
    candidates = Candidates(network, learner, fit, fit)
    result = evaluate([CALM], {"a": (features, targets)}, candidates)
    rmse = result.rmse[0]
    assert set(rmse) == set(METHODS)
    assert rmse["none"] == pytest.approx(np.sqrt((targets**2).sum(axis=1).mean()))
    assert rmse["offline"] == rmse["none"]  # The last layer is zero.
    assert rmse["online"] < 0.95 * rmse["none"]
    assert rmse["linear"] == rmse["ridge"] < 1e-9
