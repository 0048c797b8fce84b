"""Tests of the setpoints' motion in safe modes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.setpoint.integration import SetpointLimits, admissible, integrate
from aerodrake.model.supervision.safe_mode import SafeMode, SafeMotion, safe_acceleration

DT = 0.02
TUCKED = np.array([1.0, -0.5])
MOTION = SafeMotion(np.array([0.0, 0.0, -0.3, 0.0, 0.0]), TUCKED)
LIMITS = SetpointLimits(
    lower=np.array([-np.inf, -np.inf, -np.inf, -2.0, -2.0]),
    upper=np.array([np.inf, np.inf, np.inf, 2.0, 2.0]),
    velocity=np.array([1.5, 1.5, 1.5, 3.0, 3.0]),
    acceleration=np.array([2.5, 2.5, 2.5, 15.0, 15.0]),
)


def simulate(mode: SafeMode, p, v, seconds: float) -> np.ndarray:
    """Returns positions, velocities and accelerations (T, 3, 5) at each tick."""
    track = []
    for _ in range(round(seconds / DT)):
        u = safe_acceleration(MOTION, float(mode), p, v, np.full(5, np.nan))
        u = admissible(LIMITS, p, v, u, DT)
        track.append([p, v, u])
        p, v = integrate(p, v, u, DT)
    return np.array(track)


def test_nominal_returns_the_command_of_the_mpc():
    u, ones = np.arange(5.0), np.ones(5)
    np.testing.assert_array_equal(safe_acceleration(MOTION, 0.0, ones, ones, u), u)


@given(st.lists(st.floats(-1.5, 1.5), min_size=5, max_size=5))
def test_hold_comes_to_rest_within_limits_and_without_turning_back(v):
    v = np.array(v)
    track = simulate(SafeMode.HOLD, np.zeros(5), v, 4.0)
    assert np.all(np.abs(track[:, 2]) <= LIMITS.acceleration + 1e-9)
    speed = track[:, 1] * np.sign(v)
    assert np.all(np.diff(speed, axis=0) <= 1e-12) and np.all(speed >= -1e-9)
    np.testing.assert_allclose(track[-1, 1], 0, atol=1e-4)
    # Full braking, then exponential decay: at most v / 4 s on top of v^2 / (2 a).
    room = v**2 / (2 * LIMITS.acceleration) + np.abs(v) / 4 + 0.05
    assert np.all(np.abs(track[-1, 0]) <= room)


def test_hold_at_rest_stays():
    track = simulate(SafeMode.HOLD, np.arange(5.0) / 5, np.zeros(5), 1.0)
    assert np.all(track == track[0])


@pytest.mark.parametrize("mode", [SafeMode.DESCEND, SafeMode.STOP])
def test_descend_goes_straight_down_and_tucks_the_arm(mode):
    p, v = np.array([1.0, 2.0, 1.5, -1.8, 1.5]), np.array([1.0, -0.5, 0.7, 1.0, 0.0])
    track = simulate(mode, p, v, 8.0)
    np.testing.assert_allclose(track[-1, 1, :3], [0, 0, -0.3], atol=1e-6)
    np.testing.assert_allclose(track[-1, 0, 3:], TUCKED, atol=1e-3)
    np.testing.assert_allclose(track[-1, 1, 3:], 0, atol=1e-3)
    assert track[:, 1, 2].min() >= -0.3 - 1e-9
    assert np.all(np.abs(track[:, 1]) <= LIMITS.velocity + 1e-9)
    assert np.all(np.abs(track[:, 2]) <= LIMITS.acceleration + 1e-9)
