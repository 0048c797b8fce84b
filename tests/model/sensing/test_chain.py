"""Gains of the chain: a brute-force covariance recursion, and the limits of an accelerometer."""

import numpy as np
import pytest

from aerodrake.model.sensing.chain import Chain

DT = 0.01
CHAIN = Chain(value=0.002, rate=0.1, walk=2.0)


def covariance(
    gain: np.ndarray, by_tick: np.ndarray | None, accelerometer: float, ticks: int
) -> np.ndarray:
    """Returns the covariance (3, 3) of [x, rate, d] before a measurement of x, for any gains."""
    F = np.array([[1, DT, DT**2 / 2], [0, 1, DT], [0, 0, 1]])
    G = np.array([[DT**2 / 6], [DT / 2], [1]]) * CHAIN.walk * np.sqrt(DT)
    R = np.diag([CHAIN.value**2, CHAIN.rate**2])
    P = np.zeros((3, 3))
    for k in range(100 * ticks):
        if k % ticks == 0:
            before, A = P, np.eye(3) - gain @ np.eye(2, 3)
            P = A @ P @ A.T + gain @ R @ gain.T
        if by_tick is not None:
            L = by_tick[k % ticks][:, np.newaxis]
            A = np.eye(3) - L @ [[0, 0, 1]]
            P = A @ P @ A.T + L @ L.T * accelerometer**2
        P = F @ P @ F.T + G @ G.T
    return before


@pytest.mark.parametrize("ticks", [1, 4])
@pytest.mark.parametrize("accelerometer", [None, 0.3])
def test_no_gains_near_the_chosen_ones_have_smaller_errors(ticks, accelerometer):
    """Covariances of any gains are those of Joseph's form."""
    if accelerometer is None:
        gains = CHAIN.gain(DT, ticks), None
    else:
        gains = CHAIN.periodic_gains(accelerometer, DT, ticks)
    best, random = covariance(*gains, accelerometer or 0.0, ticks), np.random.default_rng(0)
    for _ in range(10):
        other = [g if g is None else g * random.uniform(0.7, 1.4, g.shape) for g in gains]
        worse = covariance(*other, accelerometer or 0.0, ticks) - best
        assert np.linalg.eigvalsh(worse).min() > -1e-9 * np.abs(best).max()


@pytest.mark.parametrize("ticks", [1, 2, 5])
def test_a_useless_accelerometer_changes_nothing(ticks):
    gain, by_tick = CHAIN.periodic_gains(1e6, DT, ticks)
    np.testing.assert_allclose(gain, CHAIN.gain(DT, ticks), rtol=1e-6)
    np.testing.assert_allclose(by_tick, 0, atol=1e-6)


def test_a_perfect_accelerometer_measures_d_itself():
    _, by_tick = CHAIN.periodic_gains(1e-9, DT, 3)
    np.testing.assert_allclose(by_tick[:, 2], 1, rtol=1e-9)


def test_rarer_measurements_have_larger_gains():
    gains = np.array([CHAIN.gain(DT, ticks) for ticks in (1, 2, 4)])
    assert np.all(np.diff(gains[:, :, 0], axis=0) > 0)
