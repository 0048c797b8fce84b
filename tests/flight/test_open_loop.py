"""Tests of the station with prescribed setpoints."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.flight.open_loop import make_open_loop
from aerodrake.model.setpoint.motion import held_acceleration_motion
from aerodrake.station import make_context, make_station

PERIOD_S = 0.01
FLOWN_S = 0.3


def names(system, kind: str) -> list[str]:
    count, port = getattr(system, f"num_{kind}_ports")(), getattr(system, f"get_{kind}_port")
    return [port(i).get_name() for i in range(count)]


@pytest.fixture(scope="module")
def motions(vehicle):
    """Motions of base and joints, with velocities and accelerations."""
    t = PERIOD_S * np.arange(round(FLOWN_S / PERIOD_S) + 1)
    swing = 0.3 * np.sin(np.pi * t / FLOWN_S)[:, None]
    base = held_acceleration_motion(vehicle.p_B, swing * [1.0, -0.5, 0.7], PERIOD_S)
    joints = held_acceleration_motion(
        vehicle.working, swing * np.linspace(-1, 1, vehicle.joints), PERIOD_S
    )
    return base, joints


def test_ports(scenario, motions):
    diagram = make_open_loop(scenario, *motions)
    outputs = names(make_station(scenario), "output")
    assert names(diagram, "input") == []
    assert names(diagram, "output") == [*outputs, "base_setpoint", "joint_setpoint"]
    assert diagram.get_name() == "open_loop"
    inside = sorted(system.get_name() for system in diagram.GetSystems())
    assert inside == ["base_setpoint", "joint_setpoint", "station"]


def test_sources_give_position_velocity_and_acceleration(scenario, motions):
    diagram = make_open_loop(scenario, *motions)
    context = diagram.CreateDefaultContext()
    for t in (0.0, 0.123, 0.29):
        context.SetTime(t)
        for port, motion in zip(("base_setpoint", "joint_setpoint"), motions, strict=True):
            expected = [motion.EvalDerivative(t, order)[:, 0] for order in range(3)]
            setpoint = diagram.GetOutputPort(port).Eval(context)
            np.testing.assert_allclose(setpoint, np.concatenate(expected), atol=1e-12)


def test_after_its_end_a_motion_stays(scenario, motions):
    diagram = make_open_loop(scenario, *motions)
    context = diagram.CreateDefaultContext()
    context.SetTime(FLOWN_S + 1)
    last = motions[0].value(FLOWN_S)[:, 0]
    setpoint = diagram.GetOutputPort("base_setpoint").Eval(context)
    np.testing.assert_allclose(setpoint, [*last, *np.zeros(6)], atol=1e-12)


def test_it_flies_like_the_station_with_the_same_setpoints(scenario, vehicle):
    """Setpoints that are constant over each period are set by hand; equal bit for bit."""
    breaks = PERIOD_S * np.arange(round(FLOWN_S / PERIOD_S) + 1)
    offset = 0.2 * (1 - np.cos(np.pi * breaks / FLOWN_S))
    p_d = vehicle.p_B + np.outer(offset, [1.0, -0.5, 0.7])
    q_d = vehicle.working + np.outer(offset, np.ones(vehicle.joints))
    base, joints = (PiecewisePolynomial.ZeroOrderHold(breaks, rows.T) for rows in (p_d, q_d))

    diagram = make_open_loop(scenario, base, joints)
    simulator = Simulator(diagram, make_context(diagram, 0))
    simulator.AdvanceTo(FLOWN_S)
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
