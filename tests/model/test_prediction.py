"""The condensed prediction against the model, step by step."""

import numpy as np
import pytest

from aerodrake.model.equivalent_model import AXIS_MODELS, EquivalentModel
from aerodrake.model.prediction import Prediction

K_B = np.array([6.67, 1.8, 2.38])


@pytest.mark.parametrize("kind", AXIS_MODELS)
@pytest.mark.parametrize(("horizon", "joints"), [(1, 6), (15, 6), (7, 2)])
def test_equals_the_model_step_by_step(kind, horizon, joints):
    model = EquivalentModel.make(kind, K_B, 0.02, joints)
    prediction = Prediction(model, horizon)
    rng = np.random.default_rng(0)
    x, delta = rng.normal(size=len(model.A)), rng.normal(size=3)
    u = rng.normal(size=(horizon, 3 + joints))
    states = prediction.free(x, delta) + prediction.Gamma @ u.ravel()
    assert states.shape == (horizon, len(model.A))
    for k in range(horizon):
        x = model.predict(x, u[k], delta)
        np.testing.assert_allclose(states[k], x, atol=1e-12)
