"""Tests of reference curves of all kinds."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.reference.curves import make_reference
from aerodrake.scenario import (
    Clover,
    FigureEight,
    Hover,
    Lissajous,
    MovingTarget,
    Waypoints,
)
from tests.model.reference.curve_strategies import CSV, START, closed, curves, quick


@quick
@given(curves, st.lists(st.floats(0.01, 100.0), min_size=1, max_size=20))
def test_velocity_is_the_derivative_of_position(config, times):
    curve, times, h = make_reference(config, START), np.array(times), 1e-5
    p, v = curve.evaluate(times)
    slope = (curve.evaluate(times + h)[0] - curve.evaluate(times - h)[0]) / (2 * h)
    assert p.shape == v.shape == (len(times), 3)
    np.testing.assert_allclose(v, slope, atol=2e-5)


@quick
@given(closed | st.just(Hover()))
def test_curves_begin_at_start_and_at_rest(config):
    p, v = make_reference(config, START).evaluate(np.array([0.0]))
    np.testing.assert_allclose(p, [START], atol=1e-12)
    np.testing.assert_array_equal(v, [[0, 0, 0]])


@quick
@given(curves)
def test_before_time_zero_the_initial_position_is_kept(config):
    curve = make_reference(config, START)
    p, v = curve.evaluate(np.array([-100.0, -1e-9, 0.0]))
    np.testing.assert_array_equal(p, np.tile(p[2], (3, 1)))
    np.testing.assert_array_equal(v[:2], np.zeros((2, 3)))


def test_hover_target_and_waypoints_have_no_lap():
    for config in (Hover(), MovingTarget(), Waypoints(str(CSV))):
        assert make_reference(config, START).lap is None


@pytest.mark.parametrize(
    ("config", "diameter"),
    [
        (Hover(), 0.0),
        (Clover(amplitude_m=0.5), 1.0),
        (FigureEight(length_m=0.6, width_m=0.6), 0.75),
        (FigureEight(length_m=1.0, width_m=0.1, tilt_rad=0.3), 1.0),
        (Lissajous((0.3, 0.4, 0.0), (8.0, 8.0, 8.0), (0.1, 0.1, 0.0)), 1.0),
        (Lissajous((0.4, 0.4, 0.1), (8.0, 8.0, 8.0), (0.0, math.pi / 2, 0.0)), 0.8246211251235321),
        (Lissajous((0.0, 0.0, 0.0)), 0.0),
        (MovingTarget(), math.inf),
    ],
)
def test_exact_diameters(config, diameter):
    assert make_reference(config, START).diameter_m == pytest.approx(diameter, abs=1e-9)


def test_moving_target_is_the_one_of_the_paper():
    p, v = make_reference(MovingTarget(), START).evaluate(np.array([-1.0, 0.0, 10.0]))
    np.testing.assert_allclose(p, [[0, 1.4, 0.6], [0, 1.4, 0.6], [0, 1.9, 0.6]])
    np.testing.assert_allclose(v, [[0, 0, 0], [0, 0.05, 0], [0, 0.05, 0]])
