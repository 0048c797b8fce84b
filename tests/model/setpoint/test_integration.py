"""Setpoints: exact integration, limits for any command, and braking as soon as they allow."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from aerodrake.model.setpoint.integration import (
    Segment,
    SetpointLimits,
    admissible,
    braking,
    evaluate,
    integrate,
    split_segment,
)
from aerodrake.scenario import Mpc

DT = 0.02
LIMITS = SetpointLimits(
    lower=np.array([-np.inf, -1.0, -0.2]),
    upper=np.array([np.inf, 2.0, 0.3]),
    velocity=np.array([1.5, 3.0, 3.0]),
    acceleration=np.array([4.0, 15.0, 15.0]),
)
TICKS = 200
STAGES_S = 0.02 * np.array([1, 1, 2, 3, 5, 8])
MOST = np.array([2.5, 15.0])


def assert_within_limits(p, v, commands):
    """Integrates the commands, and checks the limits at the ticks and between them."""
    ticks = []
    for command in commands:
        u = admissible(LIMITS, p, v, command, DT)
        ticks.append((p, v, u))
        p, v = integrate(p, v, u, DT)
    p, v, u = np.array(ticks).transpose(1, 0, 2)
    assert np.all(np.abs(u) <= LIMITS.acceleration)
    for t in np.linspace(0, DT, 5):
        position, velocity = p + v * t + u * t**2 / 2, v + u * t
        assert np.all(position >= LIMITS.lower - 1e-9) and np.all(position <= LIMITS.upper + 1e-9)
        assert np.all(np.abs(velocity) <= LIMITS.velocity + 1e-9)


@st.composite
def command_sequences(draw):
    """Random commands to each axis, constant or noisy, up to far beyond its limits."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    scale = draw(st.sampled_from([1.0, 30.0, 1e4]))
    hold = draw(st.sampled_from([1, 7, 50, TICKS]))
    levels = rng.choice([-1, 0, 1], (TICKS // hold + 1, 3)) * scale
    noise = draw(st.sampled_from([0.0, 0.3])) * rng.normal(size=(TICKS, 3)) * scale
    return np.repeat(levels, hold, axis=0)[:TICKS] + noise


def test_integrates_polynomials_exactly():
    p, v, u = np.polynomial.Polynomial([0.3, -0.2, 0.7]), 0.5, 1.4
    at, speed = integrate(np.array([0.3]), np.array([-0.2]), np.array([u]), v)
    assert at[0] == pytest.approx(p(v)) and speed[0] == pytest.approx(p.deriv()(v))


@given(
    arrays(float, (2, 3), elements=st.floats(-0.1, 0.1)),
    arrays(float, 3, elements=st.floats(-30, 30)),
    st.floats(0, 1),
)
def test_a_segment_is_a_parabola_on_each_axis(start, u, fraction):
    p, v = start
    tick = 7.0
    vector = Segment(p, v, u, tick).to_vector()
    time = tick + fraction * DT
    paths = [np.polynomial.Polynomial(c) for c in zip(p, v, u / 2, strict=True)]
    expected = np.array([[path.deriv(k)(time - tick) for path in paths] for k in range(3)])
    for first, end in ((0, 3), (0, 1), (1, 3)):
        now = evaluate(vector, time, first, end).reshape(3, -1)
        np.testing.assert_allclose(now, expected[:, first:end], atol=1e-13)


def test_segment_round_trip():
    vector = np.arange(float(Segment.size(4)))
    segment = split_segment(vector)
    assert Segment.axes(len(vector)) == len(segment.position) == 4
    np.testing.assert_array_equal(segment.to_vector(), vector)


@given(command_sequences())
def test_limits_hold_for_any_command(commands):
    assert_within_limits(np.zeros(3), np.zeros(3), commands)


@given(command_sequences(), st.floats(0, 1), st.floats(0, 1), st.sampled_from([1, -1]))
def test_limits_hold_from_any_state_that_can_stop(commands, speed, fraction, side):
    """Started between the middle and the last point from which it can stop, either way."""
    end = np.array([1e3, *(LIMITS.upper if side > 0 else -LIMITS.lower)[1:]])
    # The stop begins with up to one tick at full speed.
    a = LIMITS.acceleration
    v = speed * np.minimum(LIMITS.velocity, a * (np.sqrt(DT**2 + 2 * end / a) - DT))
    p = fraction * (end - v * DT - v**2 / (2 * a))
    assert_within_limits(side * p, side * v, commands)


@given(st.integers(0, 2**32))
def test_commands_within_limits_pass_unchanged(seed):
    """Far from every limit the command is the acceleration, to the last bit."""
    rng = np.random.default_rng(seed)
    p = rng.uniform(-0.05, 0.05, 3)
    v = rng.uniform(-0.3, 0.3, 3)
    u = rng.uniform(-1, 1, 3) * LIMITS.acceleration * 0.99
    np.testing.assert_array_equal(admissible(LIMITS, p, v, u, DT), u)


def test_nan_stays_nan():
    u = admissible(LIMITS, np.zeros(3), np.zeros(3), np.array([np.nan, 99.0, 0.0]), DT)
    np.testing.assert_array_equal(u, [np.nan, 15.0, 0.0])


def test_braking_uses_the_whole_acceleration_limit():
    """Commanded to rest within one tick."""
    p, v = np.array([0.0, 1.5, 0.0]), np.array([1.0, -3.0, 0.001])
    for _ in range(int(np.ceil(np.max(np.abs(v) / LIMITS.acceleration) / DT))):
        u = admissible(LIMITS, p, v, -v / DT, DT)
        assert np.all(np.abs(u) <= LIMITS.acceleration)
        p, slower = integrate(p, v, u, DT)
        expected = np.maximum(np.abs(v) - LIMITS.acceleration * DT, 0)
        np.testing.assert_allclose(np.abs(slower), expected, atol=1e-12)
        v = slower
    np.testing.assert_allclose(v, 0, atol=1e-12)


def test_it_comes_to_rest_at_a_position_limit():
    p, v, last = np.zeros(3), np.zeros(3), np.full(3, np.nan)
    for _ in range(TICKS):
        last = admissible(LIMITS, p, v, LIMITS.acceleration, DT)
        p, v = integrate(p, v, last, DT)
    np.testing.assert_allclose(p[1:], LIMITS.upper[1:], atol=1e-6)
    np.testing.assert_allclose(v[1:], 0, atol=1e-6)
    np.testing.assert_allclose(last[1:], 0, atol=1e-3)
    assert v[0] == pytest.approx(LIMITS.velocity[0])


def test_limits_are_the_scenarios_and_the_robots(vehicle):
    config = Mpc(base_velocity_m_s=(1.0, 2.0, 3.0), base_acceleration_m_s2=(4.0, 5.0, 6.0))
    limits = SetpointLimits.make(config, vehicle)
    np.testing.assert_array_equal(limits.upper, [np.inf] * 3 + [*vehicle.upper])
    np.testing.assert_array_equal(limits.lower, [-np.inf] * 3 + [*vehicle.lower])
    np.testing.assert_array_equal(limits.velocity, [1, 2, 3, *vehicle.velocity])
    np.testing.assert_array_equal(limits.acceleration, [4, 5, 6, *vehicle.acceleration])


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_braking_at_the_limit_until_rest(v_0, v_1):
    v = np.array([v_0, v_1])
    z = braking(v, MOST, STAGES_S).reshape(2, -1)
    assert np.all(np.abs(z) <= 1)
    left = v[:, None] + np.cumsum(z * MOST[:, None] * STAGES_S, axis=1)
    most = np.maximum(np.abs(v[:, None]) - MOST[:, None] * np.cumsum(STAGES_S), 0)
    np.testing.assert_allclose(np.abs(left), most, atol=1e-12)
    assert np.all(left * v[:, None] >= -1e-12)
