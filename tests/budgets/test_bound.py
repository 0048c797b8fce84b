"""Bound of the error by the optimal estimate of the base's position."""

import math

import numpy as np
import pytest
from scipy.linalg import expm, solve_discrete_are

from aerodrake.budgets.bound import (
    error_bound,
    gust_accelerations,
    gust_chain,
    mean_norm,
    position_variance,
)
from aerodrake.scenario.load import load_scenario, override

DELAY_S = 0.02


@pytest.fixture(scope="module")
def realistic():
    return load_scenario("clover_realistic")


def test_the_mean_norm_of_equal_deviations_is_that_of_the_maxwell_distribution():
    assert mean_norm(np.full(3, 2.0)) == pytest.approx(2 * math.sqrt(8 / math.pi), rel=1e-3)
    assert mean_norm(np.array([1.0, 0.0, 0.0])) == pytest.approx(math.sqrt(2 / math.pi), rel=0.04)


def test_the_chain_of_a_gust_is_discretised_exactly():
    sigma, T, dt, n = 0.3, 0.7, 0.05, 2000
    chain = gust_chain(sigma, T, dt)
    A = np.array([[0, 1, 0], [0, 0, 1], [0, 0, -1 / T]])
    np.testing.assert_allclose(chain.F, expm(A * dt), rtol=1e-12)
    # Covariance of the noise by the midpoint rule.
    times = (np.arange(n) + 0.5) * dt / n
    columns = np.array([expm(A * t)[:, 2] for t in times])
    expected = 2 * sigma**2 / T * columns.T @ columns * dt / n
    np.testing.assert_allclose(chain.Q, expected, rtol=1e-6, atol=1e-12)
    stationary = chain.F[2, 2] ** 2 * sigma**2 + chain.Q[2, 2]
    assert stationary == pytest.approx(sigma**2)


def test_with_samples_at_one_rate_the_variance_is_that_of_the_riccati_equation(realistic):
    late = override(realistic, {"sensors.base_delay_s": DELAY_S})
    sigma, sensors = 0.2, realistic.sensors
    dt, T = realistic.rates.sensor_period_s, realistic.wind.gust_correlation_s
    F, Q = gust_chain(sigma, T, dt)
    H, R = np.eye(2, 3), np.diag([sensors.position_noise_m**2, sensors.velocity_noise_m_s**2])
    P = solve_discrete_are(F.T, H.T, Q, R)
    P = P - P @ H.T @ np.linalg.solve(H @ P @ H.T + R, H @ P)
    variances = []
    for time_s in DELAY_S + np.arange(0.0, dt - 1e-9, realistic.rates.plant_step_s):
        F, Q = gust_chain(sigma, T, time_s)
        variances.append((F @ P @ F.T + Q)[0, 0])
    assert position_variance(late, sigma) == pytest.approx(np.mean(variances), rel=1e-6)


def test_more_information_never_raises_the_bound(realistic):
    def variance(**keys) -> float:
        return position_variance(override(realistic, keys), 0.2)

    today = variance()
    assert variance(**{"sensors.position.period_s": 0.02}) > today
    accelerometer = {"sensors.accelerometer.period_s": 0.005}
    fine = variance(**accelerometer, **{"sensors.accelerometer.noise_m_s2": 0.01})
    coarse = variance(**accelerometer, **{"sensors.accelerometer.noise_m_s2": 1.0})
    assert fine < coarse < today
    assert variance(**{"sensors.position.latency_s": [0.01, 0.02]}) > today


def test_gusts_accelerate_by_the_slope_of_the_drag(realistic):
    # Without quadratic drag the slope is the linear coefficient.
    keys = {"wind.quadratic_drag_n_s2_m2": 0.0, "wind.linear_drag_n_s_m": 0.5}
    linear = override(realistic, {**keys, "payload.mass_kg": 0.2, "mismatch.mass_scale": 1.5})
    expected = 0.5 / (4.0 * 1.5 + 0.2) * np.array(linear.wind.gust_m_s)
    np.testing.assert_allclose(gust_accelerations(linear, 4.0), expected, rtol=1e-12)
    # In a strong wind along x the slopes are 2 c |v| along it and c |v| across.
    strong = {"wind.velocity_m_s": [20.0, 0.0, 0.0], "wind.gust_m_s": [0.1, 0.1, 0.1]}
    quadratic = override(realistic, {**strong, "wind.linear_drag_n_s_m": 0.0})
    sigma = gust_accelerations(quadratic, 1.0) / 0.1
    mass = quadratic.mismatch.mass_scale + quadratic.payload.mass_kg
    np.testing.assert_allclose(sigma * mass / 0.25 / 20.0, [2, 1, 1], rtol=1e-3)


def test_without_noise_or_without_gusts_the_bound_is_zero(realistic, vehicle):
    assert error_bound(load_scenario("clover"), vehicle) == 0
    still = override(realistic, {"wind.gust_m_s": [0, 0, 0]})
    assert error_bound(still, vehicle) == 0
    assert 0.0009 < error_bound(realistic, vehicle) < 0.0011
