"""The outputs of the stages against a simulation of the model, tick by tick."""

import numpy as np
import pytest

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.prediction import Prediction
from aerodrake.model.mpc.stage_outputs import StageOutputs
from aerodrake.scenario import Flight, Model, Scenario

TICKS = np.array([1, 1, 2, 4])
SCALE = np.array([2.0, 2.0, 2.5, 15.0, 15.0, 12.0])  # Of three joints, the last another one.


def outputs(scenario: Scenario) -> tuple[EquivalentModel, StageOutputs]:
    model = EquivalentModel.of(scenario, joints=3)
    return model, StageOutputs(model, Prediction(model, TICKS), model.dt * TICKS, SCALE)


@pytest.mark.parametrize("kind", ["flight", "exact", "integral"])
def test_free_and_driven_outputs_are_the_models(kind):
    model, ours = outputs(Scenario(model=Model(kind=kind)))
    rng = np.random.default_rng(0)
    x_0, delta = rng.normal(size=len(model.A)), rng.normal(size=3)
    z = rng.normal(size=(6, len(TICKS)))
    y = ours.free @ np.concatenate([x_0, delta])
    for f, axis in enumerate(ours.axis):
        y[f] += ours.responses[ours.kind[f]] @ z[axis]
    x, a = x_0, model.acceleration @ x_0
    for k, ticks in enumerate(TICKS):
        for _ in range(ticks):
            x = model.predict(x, SCALE * z[:, k], delta)
        before, a = a, model.acceleration @ x
        speeds = [*x[model.base_velocity], *x[model.joint_velocity]]
        moved = (x - x_0)[[*model.base_position, *model.joint_position]]
        expected = [*speeds, *moved, *(a - model.acceleration @ x_0)]
        np.testing.assert_allclose(y[:15, k], expected, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(
            y[15:, k], (a - before) / (ticks * model.dt), rtol=1e-9, atol=1e-9
        )


def test_outputs_that_answer_alike_share_their_response():
    _, ours = outputs(Scenario())
    speeds, places = ours.kind[:6], ours.kind[6:12]
    for kinds in (speeds, places):
        assert kinds[0] == kinds[1] and kinds[3] == kinds[4]  # x and y, two joints.
        assert len(set(kinds)) == 4
    assert not set(speeds) & set(places)


def test_a_response_that_differs_little_is_another():
    _, ours = outputs(Scenario(flight=Flight(position_gain=(9.0, 9.000001, 9.0))))
    assert ours.kind[0] != ours.kind[1]


def test_rounding_makes_no_difference():
    """As other ways to multiply matrices have it, with more threads for one."""
    model = EquivalentModel.of(Scenario(), joints=3)
    prediction = Prediction(model, TICKS)
    exact = StageOutputs(model, prediction, model.dt * TICKS, SCALE)
    prediction.Gamma *= 1 + 1e-15 * np.random.default_rng(0).normal(size=prediction.Gamma.shape)
    rounded = StageOutputs(model, prediction, model.dt * TICKS, SCALE)
    np.testing.assert_array_equal(rounded.kind, exact.kind)
