"""Braking: rest as soon as the limits allow."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.setpoint.integration import braking

STAGES_S = 0.02 * np.array([1, 1, 2, 3, 5, 8])
MOST = np.array([2.5, 15.0])


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_it_brakes_at_the_limit_until_rest(v_0, v_1):
    v = np.array([v_0, v_1])
    z = braking(v, MOST, STAGES_S).reshape(2, -1)
    assert np.all(np.abs(z) <= 1)
    left = v[:, None] + np.cumsum(z * MOST[:, None] * STAGES_S, axis=1)
    most = np.maximum(np.abs(v[:, None]) - MOST[:, None] * np.cumsum(STAGES_S), 0)
    np.testing.assert_allclose(np.abs(left), most, atol=1e-12)
    assert np.all(left * v[:, None] >= -1e-12)
