"""Tests of closed curves against closed forms and brute force, and of their smooth start."""

import math

import numpy as np
import pytest
from hypothesis import given
from scipy.integrate import cumulative_simpson
from scipy.spatial.distance import pdist

from aerodrake.model.reference.closed_curves import MAX_LAP_S, common_period, smooth_start
from aerodrake.model.reference.curves import make_reference
from aerodrake.scenario import Lissajous
from tests.model.reference.curve_strategies import START, closed, clovers, eights, quick


@quick
@given(closed)
def test_velocity_and_acceleration_are_continuous_through_the_start(config):
    curve = make_reference(config, START)

    def jump(time: float, h: float) -> float:
        """Difference of the one-sided slopes of velocity; first order in h if continuous."""
        before, now, after = curve.evaluate(time + h * np.array([-1, 0, 1]))[1]
        return np.abs(after - 2 * now + before).max() / h

    for time in (0.0, config.start_s):
        assert jump(time, 1e-5) < 0.02 * jump(time, 1e-3) + 1e-8


@quick
@given(clovers | eights)
def test_pace_is_nominal_after_the_start(config):
    """The curve continues as if it had begun at full pace start_s / 2 later."""
    curve = make_reference(config, START)
    late = np.linspace(config.start_s, config.start_s + config.lap_s, 50)
    quickly = make_reference(type(config)(**{**vars(config), "start_s": 0.1}), START)
    for one, other in zip(
        curve.evaluate(late), quickly.evaluate(late - config.start_s / 2 + 0.05), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-9)


@quick
@given(closed)
def test_a_lap_is_the_least_time_that_closes_the_curve(config):
    curve = make_reference(config, START)
    if curve.lap is None:
        assert not any(config.amplitude_m)
        return
    begin, end = curve.lap
    assert begin == config.start_s
    for both in curve.evaluate(np.array([begin, end])):
        np.testing.assert_allclose(both[0], both[1], atol=1e-9)
    probe = np.linspace(begin, end, 7)
    for part in range(2, 7):
        shifted = curve.evaluate(probe + (end - begin) / part)[0]
        assert np.abs(shifted - curve.evaluate(probe)[0]).max() > 1e-3


@quick
@given(clovers)
def test_clover_is_the_algebraic_curve_in_the_horizontal_plane(config):
    """(x^2 + y^2)^3 = a^2 (x^2 - y^2)^2 about a centre at start - [a, 0, 0]."""
    a = config.amplitude_m
    p, _ = make_reference(config, START).evaluate(np.linspace(0, 2 * config.lap_s, 500))
    x, y, z = ((p - START + [a, 0, 0]) / a).T
    np.testing.assert_allclose((x**2 + y**2) ** 3, (x**2 - y**2) ** 2, atol=1e-12)
    np.testing.assert_array_equal(z, 0)
    for tip in ([1, 0], [-1, 0], [0, 1], [0, -1]):
        assert np.hypot(x - tip[0], y - tip[1]).min() < 0.05


@quick
@given(eights)
def test_figure_eight_is_geronos_lemniscate_in_its_plane(config):
    p, _ = make_reference(config, START).evaluate(np.linspace(0, 2 * config.lap_s, 2001))
    cos, sin = math.cos(config.tilt_rad), math.sin(config.tilt_rad)
    offset = p - START
    x = offset[:, 0] / (config.length_m / 2)
    y = offset[:, 1:] @ [cos, sin] / (config.width_m / 2)
    np.testing.assert_allclose(offset[:, 1:] @ [-sin, cos], 0, atol=1e-12)
    np.testing.assert_allclose(y**2, 4 * x**2 * (1 - x**2), atol=1e-9)
    np.testing.assert_allclose([x.max(), -x.min(), y.max(), -y.min()], 1, atol=1e-3)


@quick
@given(closed)
def test_diameter_is_the_largest_distance(config):
    curve = make_reference(config, START)
    begin, end = curve.lap or (0, 1)
    p, v = curve.evaluate(np.linspace(begin, end, 1500))
    brute = pdist(p).max()
    between_samples = np.linalg.norm(v, axis=1).max() * (end - begin) / 1499
    assert brute - 1e-12 <= curve.diameter_m <= brute + between_samples


@pytest.mark.parametrize(
    ("periods", "common"),
    [
        ([16.0, 8.0, 16.0], 16.0),
        ([1.5, 2.5], 7.5),
        ([16.0, 5.333333], 16.0),
        ([12.34, 12.34], 12.34),
        ([1.0, MAX_LAP_S], MAX_LAP_S),
        ([7.0, 999.0], None),
        ([1.0, math.sqrt(2)], None),
        ([], None),
    ],
)
def test_common_period(periods, common):
    assert common_period(np.array(periods)) == (common and pytest.approx(common))


def test_an_axis_at_rest_does_not_lengthen_the_lap():
    curve = make_reference(Lissajous((0.4, 0.3, 0.0), (16.0, 8.0, 17.0), start_s=2.0), START)
    assert curve.lap == (2.0, 18.0)


@pytest.mark.parametrize("start_s", [0.5, 3.0])
def test_time_along_the_curve_is_the_integral_of_the_pace(start_s):
    times = np.linspace(0, 2 * start_s, 401)
    s, pace = smooth_start(times, start_s)
    np.testing.assert_allclose(cumulative_simpson(pace, x=times, initial=0), s, atol=1e-6)
    assert pace[0] == 0 and np.all(np.diff(pace) >= -1e-15)
    np.testing.assert_allclose(pace[200:], 1, rtol=1e-15)
    np.testing.assert_allclose(s[200:], times[200:] - start_s / 2, rtol=1e-14)


def test_pace_has_zero_slope_at_both_ends_of_the_start():
    _, pace = smooth_start(np.array([0, 1e-4, 1 - 1e-4, 1]), 1.0)
    np.testing.assert_allclose(np.diff(pace)[[0, 2]] / 1e-4, 0, atol=1e-3)
