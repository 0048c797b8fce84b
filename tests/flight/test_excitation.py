"""Excitations: setpoints and measurements at each tick of the MPC."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.flight.excitation import excite
from aerodrake.flight.open_loop import make_open_loop
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.scenario import Filter, Rates, Scenario, Sensors
from aerodrake.station import make_context

FLOWN_S = 0.4
NOISE = Sensors(position_noise_m=0.002, velocity_noise_m_s=0.01, joint_noise_rad=0.001)


def motions(vehicle, period: float = 0.02):
    """Motions of the base along x and of all joints, from rest to rest; the latter is longer."""
    t = period * np.arange(round(FLOWN_S / period) + 1)
    speed = 0.4 * np.sin(np.pi * t / FLOWN_S)[:, None]
    base = held_acceleration_motion(vehicle.p_B, speed * [1, 0, 0], period)
    longer = np.vstack([speed, speed])
    joints = held_acceleration_motion(vehicle.working, longer * np.ones(vehicle.joints), period)
    return base, joints


@pytest.fixture(scope="module")
def flown(scenario, vehicle):
    return excite(scenario, *motions(vehicle))


def test_a_sample_at_each_tick_to_the_end_of_the_bases_motion(flown, vehicle):
    n = vehicle.joints
    np.testing.assert_allclose(flown.time_s, np.linspace(0, FLOWN_S, 21), atol=1e-12)
    assert flown.state.shape == (21, 13 + 2 * n)
    assert flown.base_setpoint.shape == (21, 9) and flown.joint_setpoint.shape == (21, 3 * n)


def test_it_starts_in_trim_and_follows(flown, vehicle):
    np.testing.assert_allclose(flown.state[0], vehicle.trim_state, atol=1e-12)
    moved = flown.state[-1, 4:7] - vehicle.p_B
    assert moved[0] == pytest.approx(0.4 * FLOWN_S * 2 / np.pi, abs=0.02)
    assert np.abs(moved[1:]).max() < 0.04  # The reaction of the arm.


def test_exact_sensors_show_the_true_state_at_the_tick(flown, scenario, vehicle):
    """The sample is of that time, not the one before, nor the plant a step later."""
    diagram = make_open_loop(scenario, *motions(vehicle))
    simulator = Simulator(diagram, make_context(diagram, scenario.seed))
    true_state = diagram.GetOutputPort("true_state")
    for tick, state in zip(flown.time_s, flown.state, strict=True):
        simulator.AdvanceTo(tick)
        np.testing.assert_allclose(state, true_state.Eval(simulator.get_context()), atol=1e-12)


def test_setpoints_equal_those_of_the_diagram(flown, scenario, vehicle):
    """The acceleration is the one from the tick on."""
    diagram = make_open_loop(scenario, *motions(vehicle))
    context = diagram.CreateDefaultContext()
    for k, tick in enumerate(flown.time_s[:-1]):
        context.SetTime(tick + 1e-9)
        for port in ("base_setpoint", "joint_setpoint"):
            setpoint = diagram.GetOutputPort(port).Eval(context)
            np.testing.assert_allclose(getattr(flown, port)[k], setpoint, atol=1e-7)
    velocity = flown.base_setpoint[:, 3]
    np.testing.assert_allclose(flown.base_setpoint[:-1, 6], np.diff(velocity) / 0.02, atol=1e-9)


def test_ticks_are_those_of_the_scenarios_mpc(vehicle):
    scenario = Scenario(rates=Rates(mpc_period_s=0.04))
    flown = excite(scenario, *motions(vehicle, 0.04))
    np.testing.assert_allclose(flown.time_s, np.linspace(0, FLOWN_S, 11), atol=1e-12)


def test_results_depend_on_the_seed_only(vehicle):
    noisy = Scenario(sensors=NOISE, seed=3)
    first, again = (excite(noisy, *motions(vehicle)).state for _ in range(2))
    np.testing.assert_array_equal(first, again)
    other = excite(replace(noisy, seed=4), *motions(vehicle)).state
    assert np.abs(first - other)[1:, 4:7].max() > 1e-3


def test_samples_have_the_noise_of_the_sensors(flown, vehicle):
    """The motion itself differs by less than the noise."""
    unfiltered = Scenario(sensors=NOISE, filter=Filter(kind="none"))
    noisy = excite(unfiltered, *motions(vehicle)).state
    difference = (noisy - flown.state)[1:, 4:7]
    assert 0.001 < difference.std() < 0.004


def test_progress_is_reported_at_each_tick(scenario, vehicle):
    times = []
    flown = excite(scenario, *motions(vehicle), progress=times.append)
    np.testing.assert_array_equal(times, flown.time_s)
