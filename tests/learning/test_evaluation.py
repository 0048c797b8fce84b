import dataclasses

import numpy as np
import pytest

from aerodrake.learning.evaluation import METHODS, Evaluation, evaluate
from aerodrake.learning.stages import Stage
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.scenario import Residual

CALM = Stage("a", "held_out", 1.0, 5.0, 0.0)
WIND, LIGHT = (dataclasses.replace(CALM, name=name, twin="a") for name in ("a_w", "a_l"))


def row(none, offline, online):
    return {"none": none, "offline": offline, "online": online, "linear": 0.0, "ridge": 0.0}


def test_what_is_removed_recovered_and_worst():
    evaluation = Evaluation(
        [CALM, WIND, LIGHT], [row(10.0, 2.0, 1.0), row(20.0, 22.0, 7.0), row(10.0, 2.1, 1.0)]
    )
    assert evaluation.removed == pytest.approx(0.8)
    assert evaluation.worst == pytest.approx(1.1)
    # 20 are added by the wind, of which 15 go; LIGHT adds 5 %, which does not count.
    assert [evaluation.recovered(i) for i in range(3)] == [None, pytest.approx(0.75), None]
    assert evaluation.least_recovered == pytest.approx(0.75)
    assert evaluation.as_mapping()["recovered"] == {"a_w": pytest.approx(0.75), "a_l": None}


def test_every_method_predicts_what_it_is_to_predict():
    generator = np.random.default_rng(0)
    features = 0.1 * generator.normal(size=(400, 30))
    targets = features[:, 3:6] + [0.03, 0.0, 0.0]
    network, gain = ResidualNetwork.untrained(6, seed=0), np.array([1.0, 0.5, 1.0])
    fit = LinearResidual.fit([(features, targets)], 0.0)
    residual = Residual(learning_rate=0.02, max_step=0.0, max_drift=0.0)
    result = evaluate([CALM], {"a": (features, targets)}, network, gain, residual, fit, fit)
    rmse = result.rmse[0]
    assert set(rmse) == set(METHODS)
    assert rmse["none"] == pytest.approx(np.sqrt((targets**2).sum(axis=1).mean()))
    assert rmse["offline"] == rmse["none"]  # Nothing was learned yet.
    assert rmse["online"] < 0.95 * rmse["none"]
    assert rmse["linear"] == rmse["ridge"] < 1e-9
