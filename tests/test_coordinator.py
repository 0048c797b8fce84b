"""Coordinator alone, with the measured state constant."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from aerodrake.model.qp import solvers
from aerodrake.scenario import MovingTarget
from aerodrake.station import make_context, make_coordinator
from aerodrake.support.errors import ScenarioError
from tests.trim import hovering


def coordinate(scenario, vehicle, duration: float):
    """Simulates the coordinator alone with the measured state in trim.

    Returns its setpoints and u every 10 ms: (samples, 9), (samples, 3 n), (samples, 3 + n).
    """
    coordinator = make_coordinator(scenario)
    context = make_context(coordinator, 0)
    for port, value in (
        ("state", vehicle.trim_state),
        ("specific_thrust", [9.81]),
        ("external_acceleration", np.zeros(3)),
        ("disturbance", np.zeros(6)),
        ("saturated", [0.0]),
    ):
        coordinator.GetInputPort(port).FixValue(context, value)
    simulator = Simulator(coordinator, context)
    rows = {port: [] for port in ("base_setpoint", "joint_setpoint", "u")}
    for k in range(round(duration / 0.01)):
        simulator.AdvanceTo(0.01 * k + 1e-6)
        for port, row in rows.items():
            row.append(coordinator.GetOutputPort(port).Eval(context).copy())
    return (np.array(row) for row in rows.values())


def test_the_coordinator_alone_holds_still_on_its_target(scenario, vehicle):
    base, joints, _ = coordinate(replace(scenario, settle_s=0.1), vehicle, 0.6)
    expected_base, expected_joints = hovering(vehicle)
    np.testing.assert_allclose(base, np.tile(expected_base, (len(base), 1)), atol=1e-6)
    np.testing.assert_allclose(joints, np.tile(expected_joints, (len(joints), 1)), atol=1e-6)


def test_the_coordinator_alone_waits_and_then_goes_to_its_target(scenario, vehicle):
    target = MovingTarget(target_m=(0.0, 1.4, 0.0), velocity_m_s=(0.0, 0.0, 0.0))
    flown = replace(scenario, settle_s=0.2, reference=target)
    base, joints, u = coordinate(flown, vehicle, 1.0)
    expected_base, expected_joints = hovering(vehicle)
    # Until then the setpoints are constant.
    np.testing.assert_allclose(base[:20], np.tile(expected_base, (20, 1)), atol=1e-9)
    np.testing.assert_allclose(joints[:20], np.tile(expected_joints, (20, 1)), atol=1e-9)
    assert np.any(u[5] != 0)
    assert base[-1, 1] > 0.02 and base[-1, 4] > 0.05
    limits = scenario.mpc.base_velocity_m_s, scenario.mpc.base_acceleration_m_s2
    assert np.all(np.abs(base[:, 3:6]) <= np.add(limits[0], 1e-9))
    assert np.all(np.abs(base[:, 6:]) <= np.add(limits[1], 1e-9))
    q, qdot, qddot = np.split(joints, 3, axis=1)
    assert np.all((vehicle.lower <= q) & (q <= vehicle.upper))
    assert np.all(np.abs(qdot) <= vehicle.velocity + 1e-9)
    assert np.all(np.abs(qddot) <= vehicle.acceleration + 1e-9)


def test_a_solver_that_the_machine_lacks_is_an_error_of_the_scenario(scenario, monkeypatch):
    missing = type("Missing", (), {"available": lambda self: False, "enabled": lambda self: True})
    monkeypatch.setattr(solvers, "OTHERS", {**solvers.OTHERS, "gurobi": missing})
    without = replace(scenario, mpc=replace(scenario.mpc, solver="gurobi"))
    with pytest.raises(ScenarioError, match="^mpc.solver: no gurobi .* available: osqp, active_"):
        make_coordinator(without)
