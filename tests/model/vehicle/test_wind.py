"""Drag compared with numbers by hand, and gusts with theory."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.wind import (
    WindField,
    discrete_gusts,
    drag,
    drag_on_base,
    is_at_rest,
    is_uniform,
    wind_at,
)
from aerodrake.scenario import Wind

JOINTS = 6
SPEEDS = st.tuples(*[st.floats(-30, 30)] * 3).map(np.array)


@pytest.mark.parametrize(
    ("v_r", "force"),
    [
        ((0, 0, 0), (0, 0, 0)),
        ((2, 0, 0), (1.3, 0, 0)),  # 0.25 * 2 * 2 + 0.15 * 2
        ((0, -1, 0), (0, -0.4, 0)),
        ((3, 0, 4), (4.2, 0, 5.6)),  # 0.25 * 5 + 0.15 = 1.4 times each.
    ],
)
def test_drag_by_hand(v_r, force):
    np.testing.assert_allclose(drag(0.25, 0.15, np.array(v_r, dtype=float)), force, atol=1e-15)


def test_linear_and_quadratic_drag():
    v_r = np.array([0.0, 3.0, 4.0])
    np.testing.assert_allclose(drag(0.5, 0.0, v_r), [0, 7.5, 10])
    np.testing.assert_allclose(drag(0.0, 0.5, v_r), [0, 1.5, 2])


@given(SPEEDS)
def test_drag_is_parallel_to_the_relative_velocity(v_r):
    force = drag(0.25, 0.15, v_r)
    np.testing.assert_allclose(np.cross(force, v_r), 0, atol=1e-9)
    assert force @ v_r >= 0
    np.testing.assert_allclose(drag(0.25, 0.15, -v_r), -force)


@given(SPEEDS, SPEEDS)
def test_drag_on_the_base_depends_on_relative_velocity(air, v_B):
    x = np.full(VehicleState.size(JOINTS), 9.0)
    x[10 + JOINTS : 13 + JOINTS] = v_B
    expected = drag(0.25, 0.15, air - v_B)
    np.testing.assert_array_equal(drag_on_base(0.25, 0.15, air, x), expected)


@given(st.floats(0.001, 0.1), st.floats(0.05, 100), st.floats(0, 5))
def test_gusts_keep_their_deviation_and_decay_with_their_correlation_time(dt, T, sigma):
    config = Wind(gust_m_s=(sigma, 0.0, 2 * sigma), gust_correlation_s=T)
    a, b = discrete_gusts(config, dt)
    assert a == pytest.approx(math.exp(-dt / T))
    # The variance is stationary.
    np.testing.assert_allclose(
        a**2 * np.square(config.gust_m_s) + b**2, np.square(config.gust_m_s), atol=1e-12
    )


def test_two_short_steps_equal_one_long_step():
    config = Wind(gust_m_s=(1.0, 2.0, 0.0), gust_correlation_s=0.7)
    (a, b), (a2, b2) = discrete_gusts(config, 0.01), discrete_gusts(config, 0.02)
    assert a2 == pytest.approx(a**2)
    np.testing.assert_allclose(b2**2, a**2 * b**2 + b**2)


def test_is_at_rest():
    assert is_at_rest(Wind())
    assert is_at_rest(Wind(quadratic_drag_n_s2_m2=3.0, gust_correlation_s=9.0))
    assert not is_at_rest(Wind(velocity_m_s=(0.0, 0.0, -0.1)))
    assert not is_at_rest(Wind(gust_m_s=(0.0, 0.1, 0.0)))
    assert not is_at_rest(Wind(wave_m_s=(0.0, 0.1, 0.0)))


def test_is_uniform():
    assert is_uniform(Wind(shear_exponent=0.2, gust_m_s=(1.0, 1.0, 1.0)))  # Without a mean.
    assert not is_uniform(Wind(shear_exponent=0.2, velocity_m_s=(1.0, 0.0, 0.0)))
    assert not is_uniform(Wind(wave_m_s=(0.0, 0.1, 0.0)))


def test_the_mean_wind_is_a_power_law_of_the_height():
    mean, gust = np.array([4.0, -2.0, 0.0]), np.array([0.3, 0.2, 0.1])
    field = WindField.make(
        Wind(velocity_m_s=tuple(mean), shear_exponent=0.5, reference_height_m=2.0)
    )
    for height, factor in ((2.0, 1.0), (8.0, 2.0), (0.5, 0.5), (-1.0, 0.0)):
        wind = wind_at(field, mean + gust, np.array([5.0, 6.0, height]))
        np.testing.assert_allclose(wind, factor * mean + gust, atol=1e-15)


def test_the_wave_is_a_sine_along_the_wave_vector():
    field = WindField.make(Wind(wave_m_s=(0.5, 0.0, 0.2), wave_rad_m=(2.0, 1.0, 0.0)))
    for p, sine in (
        ((0, 0, 1), 0),
        ((np.pi / 4, 0, 1), 1),
        ((1, -2, 7), 0),
        ((0, -np.pi / 6, 1), -0.5),
    ):
        wind = wind_at(field, np.ones(3), np.array(p, dtype=float))
        np.testing.assert_allclose(wind, 1 + sine * np.array([0.5, 0.0, 0.2]), atol=1e-12)
