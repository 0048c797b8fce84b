"""Fits of a gain with a known true value."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, lsim
from scipy.stats import linregress

from aerodrake.model.equivalent.identification import fit_gain

DT = 0.02
BLOCK = 250
T = DT * np.arange(3000)
P_D = 0.3 * (1 - np.cos(0.4 * T)) + 0.1 * np.sin(1.3 * T)


def first_order(k: float, constant: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Returns p_d - p and v of p' = k (p_d - p) + constant."""
    _, p, _ = lsim(([k], [1.0, k]), P_D + constant / k, T)
    error = P_D - p
    return error, k * error + constant


@settings(max_examples=30)
@given(k=st.floats(0.3, 10), constant=st.floats(-0.1, 0.1))
def test_a_first_order_base_has_its_gain_and_no_uncertainty(k, constant):
    error, velocity = first_order(k, constant)
    fit = fit_gain([error], [velocity], BLOCK)
    assert fit.gain == pytest.approx(k, rel=1e-9)
    np.testing.assert_allclose(fit.interval, k, rtol=1e-9)
    assert fit.r2 == pytest.approx(1)


def test_each_record_has_its_own_constant():
    records = [first_order(2.0, constant) for constant in (-0.05, 0.05, 0.4)]
    fit = fit_gain([e for e, _ in records], [v for _, v in records], BLOCK)
    assert fit.gain == pytest.approx(2.0) and fit.r2 == pytest.approx(1)


def test_one_record_is_fitted_by_least_squares():
    rng = np.random.default_rng(1)
    error, velocity = first_order(2.0, 0.1)
    velocity = velocity + 0.05 * rng.normal(size=len(T))
    fit, expected = fit_gain([error], [velocity], BLOCK), linregress(error, velocity)
    assert fit.gain == pytest.approx(expected.slope)
    assert fit.r2 == pytest.approx(expected.rvalue**2)


def test_white_noise_has_the_interval_of_the_textbook():
    """For independent samples the jackknife agrees with ordinary least squares."""
    widths = []
    for seed in range(50):
        rng = np.random.default_rng(seed)
        error = rng.normal(size=5000)
        velocity = 2 * error + rng.normal(size=5000)
        low, high = fit_gain([error], [velocity], 50).interval
        widths.append((high - low) / (2 * 1.96 * linregress(error, velocity).stderr))
    assert np.mean(widths) == pytest.approx(1, abs=0.05)


def covered(block: int, seeds: int = 300) -> float:
    """Returns how often the interval contains the true gain, for noise correlated over 0.5 s."""
    error, velocity = first_order(2.0)
    pole, hits = np.exp(-DT / 0.5), 0
    for seed in range(seeds):
        white = np.random.default_rng(seed).normal(size=(2, len(T)))
        noise = 0.05 * np.sqrt(1 - pole**2) * lfilter([1], [1, -pole], white)
        low, high = fit_gain([error] * 2, [*(velocity + noise)], block).interval
        hits += low <= 2.0 <= high
    return hits / seeds


def test_coverage_of_the_interval():
    """95 %, within the accuracy of 300 trials; blocks of single samples cover less."""
    assert covered(BLOCK) == pytest.approx(0.95, abs=0.035)
    assert covered(1) < 0.7


def test_noise_on_position_reduces_the_gain_by_its_fraction_of_the_variance():
    error, velocity = first_order(2.0)
    noise = 0.02 * np.random.default_rng(0).normal(size=len(T))
    fit = fit_gain([error + noise], [velocity], BLOCK)
    share = noise.var() / error.var()
    assert share > 0.05
    assert fit.gain == pytest.approx(2.0 / (1 + share), rel=0.02)


@pytest.mark.parametrize("samples", [500, 749, 3000 - 1])
def test_remaining_samples_join_the_last_block(samples):
    """They form no small block of their own."""
    error, velocity = (rows[:samples] for rows in first_order(2.0, 0.1))
    wave = 0.01 * np.sin(7 * T[:samples])
    fit = fit_gain([error] * 2, [velocity + wave, velocity - 2 * wave], BLOCK)
    assert fit.gain == pytest.approx(linregress(error, velocity - wave / 2).slope)
    assert fit.interval[0] < fit.gain < fit.interval[1]


def test_r2_reveals_a_base_that_is_not_first_order():
    rng = np.random.default_rng(1)
    fit = fit_gain([first_order(2.0)[0]], [rng.normal(size=len(T))], BLOCK)
    assert fit.r2 < 0.1 and fit.interval[0] < 0 < fit.interval[1]


def test_a_repeated_record_does_not_narrow_the_interval():
    """Records with the same excitation have the same errors."""
    error, velocity = first_order(2.0)
    velocity = velocity + 0.02 * np.sin(7 * T)
    once, twice = (fit_gain([error] * n, [velocity] * n, BLOCK) for n in (1, 2))
    np.testing.assert_allclose(twice.interval, once.interval)
