"""The condensed prediction against the model, tick by tick."""

import numpy as np
import pytest

from aerodrake.model.equivalent.axis_models import AXIS_MODELS
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.prediction import Prediction
from aerodrake.scenario import Model, Scenario

K_B = (6.67, 1.8, 2.38)


@pytest.mark.parametrize("kind", ["flight", *AXIS_MODELS])
@pytest.mark.parametrize(
    ("stage_ticks", "joints"), [([1], 6), ([1] * 15, 6), ([1, 1, 2, 3, 5], 2), ([4, 1, 7], 3)]
)
def test_equals_the_model_tick_by_tick(kind, stage_ticks, joints):
    """Each input held as long as its stage lasts, and Delta throughout."""
    model = EquivalentModel.of(Scenario(model=Model(kind=kind, k_b=K_B)), joints)
    prediction, N = Prediction(model, stage_ticks), len(stage_ticks)
    rng = np.random.default_rng(0)
    x, delta = rng.normal(size=len(model.A)), rng.normal(size=3)
    u = rng.normal(size=(N, 3 + joints))
    states = prediction.free(x, delta) + prediction.Gamma @ u.ravel()
    assert states.shape == (N, len(model.A))
    for k, ticks in enumerate(stage_ticks):
        for _ in range(ticks):
            x = model.predict(x, u[k], delta)
        np.testing.assert_allclose(states[k], x, atol=1e-11)


def test_no_state_knows_inputs_to_come():
    model = EquivalentModel.of(Scenario(), 6)
    prediction = Prediction(model, [1, 2, 4])
    for k in range(3):
        assert np.any(prediction.Gamma[k][:, 9 * k : 9 * (k + 1)] != 0)
        np.testing.assert_array_equal(prediction.Gamma[k][:, 9 * (k + 1) :], 0)
