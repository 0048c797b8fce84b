"""Models of one axis by K_B, compared with the differential equations they discretise."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aerodrake.model.equivalent.axis_models import AXIS_MODELS, STATES, exact_axis, paper_axis

K = 2.38


def velocity(kind: str, p, p_d, v_d, delta):
    """Returns p' by the differential equation of each kind."""
    if kind == "integral":
        return v_d
    return K * (p_d - p) + delta + (v_d if kind == "velocity_aware" else 0)


@pytest.mark.parametrize("kind", ["exact", "velocity_aware", "integral"])
@pytest.mark.parametrize("dt", [0.005, 0.02, 0.2])
def test_solves_its_equation_under_constant_input(kind, dt):
    p, p_d, v_d, delta, u = np.random.default_rng(0).normal(size=5)
    if kind == "integral":
        p = p_d

    def slope(t, y):
        return [velocity(kind, *y, delta), y[2], u]

    end = solve_ivp(slope, (0, dt), [p, p_d, v_d], rtol=1e-11, atol=1e-12).y[:, -1]
    axis = AXIS_MODELS[kind](K, dt)
    # The wrong measured velocity must not propagate.
    after = axis.A @ [p, 7.0, p_d, v_d] + axis.B * u + axis.C * delta
    expected = [end[0], velocity(kind, *end, delta), end[1], end[2]]
    np.testing.assert_allclose(after, expected, atol=1e-9)


def test_paper_axis_is_as_printed():
    """A_1, B_1 and C_1 below eq. 5, whose `k delta^2` reads k delta_t^2."""
    axis = paper_axis(3.0, 0.1)
    np.testing.assert_allclose(
        axis.A, [[0.7, 0, 0.3, 0.03], [-3, 0, 3, 0.3], [0, 0, 1, 0.1], [0, 0, 0, 1]], atol=1e-15
    )
    np.testing.assert_allclose(axis.B, [0.0015, 0.015, 0.005, 0.1], atol=1e-15)
    np.testing.assert_allclose(axis.C, [0.1, 1, 0, 0], atol=1e-15)


def test_paper_axis_converges_to_exact_with_the_period():
    """Over one second the difference from the exact form is proportional to the period."""

    def after_one_second(axis, dt):
        model = axis(2.0, dt)
        x = np.array([0.1, 0.0, -0.2, 0.3])
        for _ in range(round(1 / dt)):
            x = model.A @ x + model.B * 0.5 + model.C * 0.2
        return x

    gaps = [
        np.linalg.norm(after_one_second(paper_axis, dt) - after_one_second(exact_axis, dt))
        for dt in (0.02, 0.01, 0.005)
    ]
    assert 0 < gaps[2] < gaps[1] < gaps[0] < 0.02
    np.testing.assert_allclose(np.divide(gaps[:2], gaps[1:]), 2, rtol=0.05)


@pytest.mark.parametrize("kind", AXIS_MODELS)
def test_measured_velocity_does_not_propagate(kind):
    axis = AXIS_MODELS[kind](K, 0.02)
    assert axis.states == STATES
    assert np.all(axis.A[:, STATES.index("v")] == 0)


@pytest.mark.parametrize("kind", ["paper", "exact"])
def test_the_acceleration_is_the_slope_of_the_velocity(kind):
    """Without input, by central differences of the model's own prediction."""
    dt = 1e-4
    axis, x = AXIS_MODELS[kind](K, dt), np.array([0.1, 0.0, -0.2, 0.3])
    speeds = []
    for _ in range(3):
        x = axis.A @ x
        speeds.append(x)
    slope = (speeds[2][1] - speeds[0][1]) / (2 * dt)
    assert axis.acceleration @ speeds[1] == pytest.approx(slope, rel=2 * K * dt)
    assert abs(slope) > 0.5


@pytest.mark.parametrize("kind", ["velocity_aware", "integral"])
def test_models_without_acceleration_have_zero_rows(kind):
    np.testing.assert_array_equal(AXIS_MODELS[kind](K, 0.02).acceleration, np.zeros(4))


@pytest.mark.parametrize("kind", ["exact", "velocity_aware"])
def test_a_constant_residual_gives_a_steady_error_of_delta_over_k(kind):
    axis, x = AXIS_MODELS[kind](K, 0.02), np.zeros(4)
    for _ in range(1000):
        x = axis.A @ x + axis.C * 0.3
    np.testing.assert_allclose(x, [0.3 / K, 0, 0, 0], atol=1e-9)
    assert axis.C[0] == pytest.approx((1 - math.exp(-K * 0.02)) / K, rel=1e-12)
