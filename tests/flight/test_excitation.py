"""The station with prescribed setpoints, and excitations: its flights at each tick of the MPC."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.flight.excitation import excite, make_open_loop
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.scenario import Filter, Rates, Scenario, Sensors
from aerodrake.station import make_context, make_station

FLOWN_S = 0.4
SWING_PERIOD_S = 0.01
SWING_S = 0.3
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


# The open loop.


def names(system, kind: str) -> list[str]:
    count, port = getattr(system, f"num_{kind}_ports")(), getattr(system, f"get_{kind}_port")
    return [port(i).get_name() for i in range(count)]


@pytest.fixture(scope="module")
def swings(vehicle):
    """Motions of base and joints, with velocities and accelerations."""
    t = SWING_PERIOD_S * np.arange(round(SWING_S / SWING_PERIOD_S) + 1)
    swing = 0.3 * np.sin(np.pi * t / SWING_S)[:, None]
    base = held_acceleration_motion(vehicle.p_B, swing * [1.0, -0.5, 0.7], SWING_PERIOD_S)
    joints = held_acceleration_motion(
        vehicle.working, swing * np.linspace(-1, 1, vehicle.joints), SWING_PERIOD_S
    )
    return base, joints


def test_ports(scenario, swings):
    diagram = make_open_loop(scenario, *swings)
    outputs = names(make_station(scenario), "output")
    assert names(diagram, "input") == []
    assert names(diagram, "output") == [*outputs, "base_setpoint", "joint_setpoint"]
    assert diagram.get_name() == "open_loop"
    inside = sorted(system.get_name() for system in diagram.GetSystems())
    assert inside == ["base_setpoint", "joint_setpoint", "station"]


def test_sources_give_position_velocity_and_acceleration(scenario, swings):
    diagram = make_open_loop(scenario, *swings)
    context = diagram.CreateDefaultContext()
    for t in (0.0, 0.123, 0.29):
        context.SetTime(t)
        for port, motion in zip(("base_setpoint", "joint_setpoint"), swings, strict=True):
            expected = [motion.EvalDerivative(t, order)[:, 0] for order in range(3)]
            setpoint = diagram.GetOutputPort(port).Eval(context)
            np.testing.assert_allclose(setpoint, np.concatenate(expected), atol=1e-12)


def test_after_its_end_a_motion_stays(scenario, swings):
    diagram = make_open_loop(scenario, *swings)
    context = diagram.CreateDefaultContext()
    context.SetTime(SWING_S + 1)
    last = swings[0].value(SWING_S)[:, 0]
    setpoint = diagram.GetOutputPort("base_setpoint").Eval(context)
    np.testing.assert_allclose(setpoint, [*last, *np.zeros(6)], atol=1e-12)


def test_it_flies_like_the_station_with_the_same_setpoints(scenario, vehicle):
    """Setpoints that are constant over each period are set by hand; equal bit for bit."""
    breaks = SWING_PERIOD_S * np.arange(round(SWING_S / SWING_PERIOD_S) + 1)
    offset = 0.2 * (1 - np.cos(np.pi * breaks / SWING_S))
    p_d = vehicle.p_B + np.outer(offset, [1.0, -0.5, 0.7])
    q_d = vehicle.working + np.outer(offset, np.ones(vehicle.joints))
    base, joints = (PiecewisePolynomial.ZeroOrderHold(breaks, rows.T) for rows in (p_d, q_d))

    diagram = make_open_loop(scenario, base, joints)
    simulator = Simulator(diagram, make_context(diagram, 0))
    simulator.AdvanceTo(SWING_S)
    flown = diagram.GetOutputPort("true_state").Eval(simulator.get_context())

    station = make_station(scenario)
    context = make_context(station, 0)
    simulator = Simulator(station, context)
    for k, end in enumerate(breaks[1:]):
        station.GetInputPort("base_setpoint").FixValue(context, [*p_d[k], *np.zeros(6)])
        resting = np.zeros(2 * vehicle.joints)
        station.GetInputPort("joint_setpoint").FixValue(context, [*q_d[k], *resting])
        simulator.AdvanceTo(end)
    np.testing.assert_array_equal(flown, station.GetOutputPort("true_state").Eval(context))
    assert np.abs(flown - vehicle.trim_state).max() > 0.01
