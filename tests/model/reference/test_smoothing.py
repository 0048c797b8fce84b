"""Smooth paths near rounded waypoints."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.model.reference.closed_curves import CloverCurve
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.smoothing import smooth_waypoints
from aerodrake.model.reference.waypoints import interpolate_waypoints
from aerodrake.scenario import Clover, Waypoints
from aerodrake.support.errors import BadInput

START = np.array([0.0, 0.2, 1.2])
CLOVER = CloverCurve(Clover(), START)
FINE = np.linspace(0.0, 11.5, 4001)
"""s; the file ends at 12 s in motion, which its rest there deforms."""


def errors(path):
    """Returns mean errors of position and velocity, m and m/s, against the exact curve."""
    moved = path.vector_values(FINE).T, path.derivative().vector_values(FINE).T
    exact = CLOVER.evaluate(FINE)
    return [np.linalg.norm(a - b, axis=1).mean() for a, b in zip(moved, exact, strict=True)]


@pytest.mark.parametrize("rate_hz", [30, 100, 500])
@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_smoothing_removes_most_of_the_rounding(rate_hz, step):
    times = np.arange(0.0, 12.0, 1 / rate_hz)
    rounded = step * np.round(CLOVER.evaluate(times)[0] / step)
    interpolated = errors(interpolate_waypoints(times, rounded))
    smoothed = errors(smooth_waypoints(times, rounded, step))
    assert smoothed[0] < 0.4 * interpolated[0]
    assert smoothed[1] < 0.1 * interpolated[1]
    assert smoothed[1] < 0.005


tables = st.integers(2, 12).flatmap(
    lambda count: st.tuples(
        st.lists(st.floats(1e-3, 3), min_size=count, max_size=count),
        st.lists(st.tuples(*[st.floats(-5, 5)] * 3), min_size=count, max_size=count),
        st.floats(1e-6, 0.1),
    )
)


@settings(max_examples=15, deadline=None)
@given(tables)
def test_any_points_give_a_finite_path_from_rest_to_rest(table):
    steps, points, step = table
    times, points = np.cumsum(steps), np.array(points)
    path = smooth_waypoints(times, points, step)
    ends = times[[0, -1]]
    np.testing.assert_allclose(path.vector_values(ends).T, points[[0, -1]], atol=1e-12)
    np.testing.assert_allclose(path.derivative().vector_values(ends), 0.0, atol=1e-9)
    outside = [times[0] - 1, times[-1] + 1]
    np.testing.assert_allclose(path.vector_values(outside).T, points[[0, -1]], atol=1e-12)
    assert np.isfinite(path.vector_values(np.linspace(*ends, 200))).all()


def test_deviations_are_those_of_rounding():
    times, step = np.arange(0.0, 12.0, 0.01), 1e-3
    exact = CLOVER.evaluate(times)[0]
    noisy = exact + np.random.default_rng(0).normal(0.0, step / np.sqrt(12), exact.shape)
    path = smooth_waypoints(times, noisy, step)
    deviations = path.vector_values(times).T - noisy
    rms = np.sqrt(np.mean(deviations[:1100] ** 2, axis=0))
    assert rms == pytest.approx(step / np.sqrt(12), rel=0.1)
    assert np.sqrt(np.mean(np.square(errors(path)[0]))) < 0.1 * step


def test_a_point_at_rest_stays_at_rest():
    times = np.arange(0.0, 12.0, 0.01)
    path = smooth_waypoints(times, np.tile(START, (len(times), 1)), 1e-2)
    np.testing.assert_allclose(
        path.vector_values(FINE).T, np.tile(START, (len(FINE), 1)), atol=1e-9
    )


def test_the_scenario_decides(tmp_path):
    times, file = np.arange(0.0, 12.0, 0.1), tmp_path / "path.csv"
    points = np.round(CLOVER.evaluate(times)[0], 2)
    np.savetxt(file, np.column_stack([times, points]), "%.3f", ",", header="t,x,y,z", comments="")
    for key, path in (
        ({}, interpolate_waypoints(times, points)),
        ({"rounding_m": 0.01}, smooth_waypoints(times, points, 0.01)),
    ):
        curve = make_reference(Waypoints(str(file), **key), START)
        p, v = curve.evaluate(FINE)
        np.testing.assert_allclose(p, path.vector_values(FINE).T, atol=1e-12)
        np.testing.assert_allclose(v, path.derivative().vector_values(FINE).T, atol=1e-9)


def test_a_step_that_is_too_small_is_refused_with_the_actual_one(tmp_path):
    times, file = np.arange(0.0, 12.0, 0.01), tmp_path / "path.csv"
    points = np.round(CLOVER.evaluate(times)[0], 3)
    np.savetxt(file, np.column_stack([times, points]), "%.3f", ",", header="t,x,y,z")
    with pytest.raises(BadInput, match=r"path.csv: .* rounded to 0.0002 m .* rounded to 0.001 m$"):
        make_reference(Waypoints(str(file), rounding_m=2e-4), START)
