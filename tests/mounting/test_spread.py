"""Points that are spread evenly."""

import numpy as np

from aerodrake.mounting.spread import spread


def test_points_are_spread_and_repeatable():
    points = spread(64, 5)
    assert points.shape == (64, 5) and (points >= 0).all() and (points < 1).all()
    np.testing.assert_array_equal(points, spread(64, 5))
    assert np.abs(points.mean(axis=0) - 0.5).max() < 0.06
