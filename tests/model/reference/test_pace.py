"""The smooth start."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from aerodrake.model.reference.pace import smooth_start


@pytest.mark.parametrize("start_s", [0.5, 3.0])
def test_time_along_the_curve_is_the_integral_of_the_pace(start_s):
    times = np.linspace(0, 2 * start_s, 401)
    s, pace = smooth_start(times, start_s)
    np.testing.assert_allclose(cumulative_simpson(pace, x=times, initial=0), s, atol=1e-6)
    assert pace[0] == 0 and np.all(np.diff(pace) >= -1e-15)
    np.testing.assert_allclose(pace[200:], 1, rtol=1e-15)
    np.testing.assert_allclose(s[200:], times[200:] - start_s / 2, rtol=1e-14)


def test_acceleration_is_continuous():
    """The pace sets out and arrives with slope 0."""
    _, pace = smooth_start(np.array([0, 1e-4, 1 - 1e-4, 1]), 1.0)
    np.testing.assert_allclose(np.diff(pace)[[0, 2]] / 1e-4, 0, atol=1e-3)
