"""Setpoint integrator over time: polynomials, limits, and continuity."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator

from aerodrake.model.setpoint.integration import Segment, SetpointLimits
from aerodrake.model.supervision.safe_mode import BRAKING_1_S, SafeMode, SafeMotion
from aerodrake.systems.setpoint_integrator import SetpointIntegrator

DT = 0.02
INF = np.inf
LIMITS = SetpointLimits(
    lower=np.array([-INF, -INF, -INF, -0.8, -0.3]),
    upper=np.array([INF, INF, INF, 0.5, 0.4]),
    velocity=np.array([1.5, 1.5, 1.0, 3.0, 2.0]),
    acceleration=np.array([4.0, 4.0, 3.0, 15.0, 10.0]),
)
START = np.array([0.0, -1.0, 1.5, 0.1, -0.1])
SIZE = len(START)
TUCKED = np.array([0.3, 0.1])
MOTION = SafeMotion(np.array([0.0, 0.0, -0.3, 0.0, 0.0]), TUCKED)


class Driver:
    """Setpoint integrator in a Simulator, from rest at `START`."""

    def __init__(self):
        self.system = SetpointIntegrator(LIMITS, MOTION, START, DT)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.command(np.zeros(SIZE))
        self.enter(SafeMode.NOMINAL)

    def enter(self, mode: SafeMode) -> None:
        self.system.GetInputPort("mode").FixValue(self.context, [float(mode)])

    def brake(self) -> None:
        """Commands rest at the next tick; call it just after each tick."""
        self.command(-self.now[1] / DT)

    def command(self, u) -> None:
        self.system.GetInputPort("u").FixValue(self.context, u)

    def advance(self, time: float) -> np.ndarray:
        """Returns position, velocity and acceleration (3, 3 + n) at `time`."""
        self.simulator.AdvanceTo(time)
        return self.now

    @property
    def now(self) -> np.ndarray:
        base = self.system.GetOutputPort("base_setpoint").Eval(self.context).reshape(3, 3)
        joints = self.system.GetOutputPort("joint_setpoint").Eval(self.context).reshape(3, -1)
        return np.hstack([base, joints])


def after_tick(k: int) -> float:
    """Returns a time in s just after tick k and its update."""
    return k * DT + 1e-9


def test_starts_at_rest_and_stays_there_without_a_command():
    driver = Driver()
    for time in (0.0, 0.013, 0.5):
        np.testing.assert_array_equal(driver.advance(time), [START, 0 * START, 0 * START])


def test_exact_polynomial_between_ticks():
    driver = Driver()
    u = np.array([1.0, -2.0, 0.5, 4.0, -3.0])
    driver.advance(1e-12)
    driver.command(u)
    for t in np.linspace(0.0001, 0.0199, 12):
        expected = [START + u * t**2 / 2, u * t, u]
        np.testing.assert_allclose(driver.advance(t), expected, atol=1e-14)


def test_exact_from_tick_to_tick():
    """Against the sum of the moments of all accelerations so far, in closed form."""
    us = np.random.default_rng(0).uniform(-1, 1, (40, SIZE))
    driver = Driver()
    for k, u in enumerate(us):
        driver.advance(after_tick(k))
        driver.command(u)
    v = DT * us.sum(axis=0)
    p = START + DT**2 * ((len(us) - np.arange(len(us)) - 0.5)[:, None] * us).sum(axis=0)
    # At the instant of the tick itself, before its update: what the MPC's tick sees.
    np.testing.assert_allclose(driver.advance(len(us) * DT), [p, v, us[-1]], atol=1e-12)
    # And after it, without a jump.
    driver.advance(after_tick(len(us)))
    np.testing.assert_allclose(driver.now[:2], [p, v], atol=1e-7)


@pytest.mark.parametrize("side", [1, -1])
def test_hard_commands_stay_within_the_limits(side):
    driver = Driver()
    driver.command(side * 1e3 * np.ones(SIZE))
    for k in range(1, 200):
        p, v, u = driver.advance(k * 0.011)
        assert np.all((LIMITS.lower - 1e-9 <= p) & (p <= LIMITS.upper + 1e-9))
        assert np.all(np.abs(v) <= LIMITS.velocity + 1e-9)
        assert np.all(np.abs(u) <= LIMITS.acceleration)
    np.testing.assert_allclose(v[:3], side * np.array([1.5, 1.5, 1.0]), atol=1e-9)


@pytest.mark.parametrize("side", [1, -1])
def test_hard_commands_come_to_rest_at_the_position_limits(side):
    driver = Driver()
    driver.command(side * 1e3 * np.ones(SIZE))
    p, v, u = driver.advance(after_tick(100))[:, 3:]
    np.testing.assert_allclose(p, (LIMITS.upper if side > 0 else LIMITS.lower)[3:], atol=1e-6)
    np.testing.assert_allclose(v, 0, atol=1e-6)
    np.testing.assert_allclose(u, 0, atol=1e-3)


def assert_smooth(track: np.ndarray, step: float) -> None:
    """Asserts that samples (T, 3, m) change no faster than the limits allow."""
    p, v, _ = np.moveaxis(track, 1, 0)
    assert np.all(np.abs(np.diff(v, axis=0)) <= LIMITS.acceleration * step + 1e-7)
    mean = (v[1:] + v[:-1]) / 2
    bound = LIMITS.acceleration * step**2 / 2
    assert np.all(np.abs(np.diff(p, axis=0) - mean * step) <= bound + 1e-9)


def test_setpoints_never_jump():
    """For random commands, and for commands to rest."""
    driver, rng, track = Driver(), np.random.default_rng(1), []
    for k in range(2000):
        track.append(driver.advance(k * 0.001 + 1e-9))
        if k % 20 == 0 and 400 < k < 1400:
            driver.brake()
        elif k % 20 == 0:
            driver.command(rng.uniform(-5, 5, SIZE))
    track = np.array(track)
    assert_smooth(track, 0.001)
    assert np.abs(track[200:400, 1]).max() > 0.3  # It moved,
    np.testing.assert_allclose(track[1000:1400, 1], 0, atol=1e-9)  # stopped,
    assert np.abs(track[1500:, 1]).max() > 0.1  # and moved again.


def test_braking_takes_as_long_as_the_acceleration_limit_requires():
    driver = Driver()
    driver.command([4.0, 0.0, -3.0, 15.0, 0.0])
    _, v, _ = driver.advance(after_tick(5))
    np.testing.assert_allclose(v, [0.4, 0, -0.3, 1.5, 0], atol=1e-6)
    for k, left in ((6, 0.8), (7, 0.6), (8, 0.4), (9, 0.2), (10, 0.0)):
        driver.brake()
        _, v, _ = driver.advance(after_tick(k))
        np.testing.assert_allclose(v, left * np.array([0.4, 0, -0.3, 1.5, 0]), atol=1e-6)


@given(st.floats(0.0, 0.02), st.integers(1, 40))
def test_braking_keeps_the_position_limits(slack, ticks):
    """If full speed towards a limit is interrupted anywhere, the stop is within it."""
    driver = Driver()
    driver.command(np.array([0.0, 0.0, 0.0, 15.0, 10.0]) - slack * 100)
    driver.advance(after_tick(ticks))
    for k in range(ticks, ticks + 30):
        driver.brake()
        driver.advance((k + 0.5) * DT)
        assert np.all(driver.now[0] <= LIMITS.upper + 1e-9)
        p, _, _ = driver.advance(after_tick(k + 1))
        assert np.all(p <= LIMITS.upper + 1e-9)


def test_safe_modes_start_at_the_next_tick_without_a_jump():
    """On entry and on exit, within limits."""
    driver, rng, track = Driver(), np.random.default_rng(2), []
    modes = {300: SafeMode.HOLD, 1507: SafeMode.NOMINAL, 1801: SafeMode.DESCEND}
    for k in range(6000):
        if k in modes:
            before = driver.now
            driver.enter(modes[k])
            np.testing.assert_array_equal(driver.now, before)
        track.append(driver.advance(k * 0.001 + 1e-9))
        if k % 20 == 0:
            driver.command(rng.uniform(-5, 5, SIZE))
    track = np.array(track)
    assert_smooth(track, 0.001)
    assert np.abs(track[300, 1]).max() > 0.1  # It moved,
    np.testing.assert_allclose(track[1500, 1], 0, atol=0.01)  # stopped,
    assert np.abs(track[1800, 1]).max() > 0.1  # moved again,
    np.testing.assert_allclose(track[-1, 1], [0, 0, -0.3, 0, 0], atol=0.02)  # and went down.
    np.testing.assert_allclose(track[-1, 0, 3:], TUCKED, atol=0.02)


def test_a_mode_acts_from_the_next_tick_on():
    driver = Driver()
    driver.command(np.ones(SIZE))
    driver.advance(after_tick(3))
    driver.advance(3.5 * DT)
    driver.enter(SafeMode.HOLD)
    np.testing.assert_allclose(driver.advance(3.9 * DT)[2], 1, atol=1e-9)
    _, v, u = driver.advance(after_tick(4))
    np.testing.assert_allclose(u, -BRAKING_1_S * v, atol=1e-6)


def test_a_command_that_changes_between_ticks_counts_from_the_last_tick():
    """u should be constant between ticks; after a change the setpoints still keep the limits."""
    driver = Driver()
    driver.command(np.ones(SIZE))
    driver.advance(after_tick(1))
    p, v, _ = driver.now
    driver.advance(1.5 * DT)
    for u in (-2 * np.ones(SIZE), 1e3 * np.ones(SIZE)):
        driver.command(u)
        t, allowed = DT / 2, np.minimum(u, LIMITS.acceleration)
        expected = [p + v * t + allowed * t**2 / 2, v + allowed * t, allowed]
        np.testing.assert_allclose(driver.now, expected, atol=1e-7)
    expected = [p + v * DT + allowed * DT**2 / 2, v + allowed * DT, allowed]
    np.testing.assert_allclose(driver.advance(2 * DT), expected, atol=1e-7)


def test_between_ticks_limits_are_not_evaluated(monkeypatch):
    """They are evaluated once after each tick, and once before the first."""
    times, calc = [], SetpointIntegrator._calc_segment

    def count(system, context, output):
        times.append(context.get_time())
        calc(system, context, output)

    monkeypatch.setattr(SetpointIntegrator, "_calc_segment", count)
    driver = Driver()
    for k in range(100):
        driver.advance(k * 0.001 + 1e-9)
    np.testing.assert_allclose(times, DT * np.array([0, 0, 1, 2, 3, 4]), atol=1e-8)


def test_an_integrator_that_follows_another_starts_each_tick_from_its_segment():
    driver = Driver()
    driver.command(np.full(SIZE, 0.5))
    driver.advance(after_tick(1))
    followed = Segment(START + 0.2, np.full(SIZE, 0.1), np.full(SIZE, -0.3), DT)
    driver.system.GetInputPort("followed").FixValue(driver.context, followed.to_vector())
    before = driver.now.copy()
    driver.command(np.zeros(SIZE))
    p, v, _ = driver.advance(2 * DT - 1e-6)  # Only at the tick.
    np.testing.assert_allclose(p, before[0] + DT * before[1], atol=1e-6)
    p, v, u = driver.advance(after_tick(2))
    np.testing.assert_allclose(p, START + 0.2 + 0.1 * DT - 0.3 * DT**2 / 2, atol=1e-8)
    np.testing.assert_allclose(v, 0.1 - 0.3 * DT, atol=1e-8)
    np.testing.assert_allclose(u, 0.0, atol=1e-12)


def test_ports_rate_and_feedthrough():
    system = SetpointIntegrator(LIMITS, MOTION, START, DT)
    assert system.GetInputPort("u").size() == SIZE
    assert [system.get_input_port(i).get_name() for i in range(system.num_input_ports())] == [
        *("u", "mode", "followed", "state", "position_offset"),
    ]
    assert system.GetOutputPort("base_setpoint").size() == 9
    assert system.GetOutputPort("joint_setpoint").size() == 3 * (SIZE - 3)
    for port in ("base_setpoint", "joint_setpoint"):
        assert system.HasDirectFeedthrough(0, system.GetOutputPort(port).get_index())
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert (timing.period_sec(), timing.offset_sec()) == (DT, 0)
