"""Reference curves against finite differences, closed forms and brute force."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from aerodrake.model.reference.curves import (
    MAX_LAP_S,
    common_period,
    make_reference,
)
from aerodrake.model.reference.diameter import farthest_pair, path_diameter
from aerodrake.scenario import (
    Clover,
    FigureEight,
    Hover,
    Lissajous,
    MovingTarget,
    Waypoints,
)

START = np.array([0.0, 0.2, 1.2])
CSV = Path(__file__).parents[3] / "aerodrake" / "scenarios" / "waypoints.csv"

lengths = st.floats(0.05, 2.0)
laps = st.floats(2.0, 60.0)
starts = st.floats(0.5, 5.0)
angles = st.floats(-1.5, 1.5)


def triples(element):
    return st.tuples(element, element, element)


clovers = st.builds(Clover, amplitude_m=lengths, lap_s=laps, start_s=starts)
eights = st.builds(
    FigureEight, length_m=lengths, width_m=lengths, tilt_rad=angles, lap_s=laps, start_s=starts
)
lissajous = st.builds(
    Lissajous,
    amplitude_m=triples(st.just(0.0) | lengths),
    period_s=triples(st.sampled_from([4.0, 6.0, 7.5, 8.0, 12.0])),
    phase_rad=triples(angles),
    start_s=starts,
)
closed = clovers | eights | lissajous
targets = st.builds(MovingTarget, velocity_m_s=triples(st.floats(-1, 1)))
curves = closed | targets | st.just(Hover()) | st.just(Waypoints(str(CSV)))

quick = settings(max_examples=30, deadline=None)


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
def test_before_time_zero_the_initial_position_holds(config):
    curve = make_reference(config, START)
    p, v = curve.evaluate(np.array([-100.0, -1e-9, 0.0]))
    np.testing.assert_array_equal(p, np.tile(p[2], (3, 1)))
    np.testing.assert_array_equal(v[:2], np.zeros((2, 3)))


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
def test_after_the_start_the_pace_is_nominal(config):
    """The curve runs as if it had begun at full pace start_s / 2 later."""
    curve = make_reference(config, START)
    late = np.linspace(config.start_s, config.start_s + config.lap_s, 50)
    quickly = make_reference(type(config)(**{**vars(config), "start_s": 1e-6}), START)
    for one, other in zip(
        curve.evaluate(late), quickly.evaluate(late - config.start_s / 2 + 5e-7), strict=True
    ):
        np.testing.assert_allclose(one, other, atol=1e-9)


@quick
@given(closed)
def test_a_lap_closes_and_is_the_least_that_does(config):
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


def test_hover_target_and_waypoints_have_no_lap():
    for config in (Hover(), MovingTarget(), Waypoints(str(CSV))):
        assert make_reference(config, START).lap is None


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


def test_path_diameter_finds_a_maximum_between_samples():
    def ellipse(s):
        return np.stack([2 * np.cos(s - 0.123), np.sin(s - 0.123), 0 * s], axis=-1)

    assert path_diameter(ellipse, np.linspace(0, 2 * np.pi, 50)) == pytest.approx(4, abs=1e-9)


@quick
@given(st.integers(1, 400), st.integers(0, 3), st.integers(0, 2**32 - 1))
def test_farthest_pair_is_that_of_all_pairs(count, flat_axes, seed):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    points[:, :flat_axes] = 1.0
    i, j = farthest_pair(points)
    largest = max(pdist(points), default=0.0)
    assert np.linalg.norm(points[i] - points[j]) == pytest.approx(largest, abs=1e-12)


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


def test_an_axis_that_stands_still_does_not_lengthen_the_lap():
    curve = make_reference(Lissajous((0.4, 0.3, 0.0), (16.0, 8.0, 17.0), start_s=2.0), START)
    assert curve.lap == (2.0, 18.0)


def test_moving_target_is_the_papers():
    p, v = make_reference(MovingTarget(), START).evaluate(np.array([-1.0, 0.0, 10.0]))
    np.testing.assert_allclose(p, [[0, 1.4, 0.6], [0, 1.4, 0.6], [0, 1.9, 0.6]])
    np.testing.assert_allclose(v, [[0, 0, 0], [0, 0.05, 0], [0, 0.05, 0]])
