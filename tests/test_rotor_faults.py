"""Tests of rotor and joint faults, pushes and landings in the closed loop."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.trajectories import PiecewisePolynomial

from aerodrake.flight.excitation import make_open_loop
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Clover, JointDegraded, Push, RotorDegraded, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop, make_context
from tests.robots import multibody_plant

SETTLE_S, FAULT_S = 0.3, 0.5
"""s, settling time, and reference time of the fault, at which the clover has begun."""


def fly(scenario: Scenario, ports: tuple[str, ...], until: float) -> dict[str, np.ndarray]:
    """Returns the values of ports every 10 ms up to a reference time."""
    diagram = make_closed_loop(scenario)
    context = make_context(diagram, scenario.seed)
    simulator, rows = Simulator(diagram, context), []
    for k in range(round((scenario.settle_s + until) / 0.01) + 1):
        simulator.AdvanceTo(k * 0.01 + 0.002)
        rows.append([diagram.GetOutputPort(port).Eval(context).copy() for port in ports])
    return {port: np.array([row[i] for row in rows]) for i, port in enumerate(ports)}


def with_faults(*faults, **changes) -> Scenario:
    clover = Clover(start_s=0.2)
    return Scenario(settle_s=SETTLE_S, reference=clover, faults=faults, **changes)


@pytest.mark.parametrize("rotor", [0, 3])
def test_a_lost_rotor_is_isolated_within_80_ms(rotor):
    scenario = with_faults(RotorDegraded(FAULT_S, 10.0, rotor=rotor, remaining=0.0))
    log = fly(scenario, ("rotor_effectiveness", "thrust", "thrust_command"), FAULT_S + 0.1)
    start, estimate = round((SETTLE_S + FAULT_S) / 0.01), log["rotor_effectiveness"]
    np.testing.assert_array_equal(estimate[:start], 1)
    assert np.all(estimate[start + 8 :, rotor] < 0.4)
    np.testing.assert_array_equal(np.delete(estimate, rotor, axis=1), 1)
    assert np.all(log["thrust"][:start] > 1) and np.all(log["thrust"][start:, rotor] == 0)
    assert np.all(log["thrust_command"][start:, rotor] > 1)


def test_a_lost_rotor_is_isolated_under_noise_wind_and_mismatch():
    realistic = load_scenario("clover_realistic")
    scenario = replace(realistic, faults=(RotorDegraded(1.0, 10.0, rotor=1, remaining=0.0),))
    estimate = fly(scenario, ("rotor_effectiveness",), 1.2)["rotor_effectiveness"]
    start = round((scenario.settle_s + 1.0) / 0.01)
    np.testing.assert_array_equal(estimate[:start], 1)
    assert np.all(estimate[start + 20 :, 1] < 0.4)
    np.testing.assert_array_equal(np.delete(estimate, 1, axis=1), 1)


def test_a_degraded_rotor_is_isolated_and_compensated():
    scenario = with_faults(RotorDegraded(FAULT_S, 10.0, rotor=2, remaining=0.8))
    log = fly(scenario, ("rotor_effectiveness", "true_state", "base_setpoint"), FAULT_S + 3.0)
    assert 0.75 < log["rotor_effectiveness"][-1, 2] < 0.9
    assert log["rotor_effectiveness"].min() > 0.7
    error = np.linalg.norm(log["true_state"][:, 4:7] - log["base_setpoint"][:, :3], axis=1)
    assert error.max() < 0.08 and error[-1] < 0.01


def test_a_degraded_joint_gives_its_remaining_torque(vehicle):
    scenario = with_faults(JointDegraded(FAULT_S, 10.0, joint=2, remaining=0.5))
    torque = fly(scenario, ("joint_torque",), FAULT_S + 0.05)["joint_torque"]
    start = round((SETTLE_S + FAULT_S) / 0.01)
    before, at = torque[start - 1], torque[start]
    assert at[2] == pytest.approx(before[2] / 2, rel=0.1)
    np.testing.assert_allclose(np.delete(at, 2), np.delete(before, 2), rtol=0.1, atol=0.02)


def test_a_push_accelerates_the_vehicle(vehicle):
    """The acceleration is force over mass before the controllers react."""
    scenario = with_faults(Push(FAULT_S, 10.0, (0.0, 0.0, -6.0)))
    undisturbed = with_faults()
    after = SETTLE_S + FAULT_S + 0.01
    v = []
    for flown in (scenario, undisturbed):
        diagram = make_closed_loop(flown)
        context = make_context(diagram, 0)
        Simulator(diagram, context).AdvanceTo(after)
        v.append(diagram.GetOutputPort("true_state").Eval(context)[16:19])
    # At first the arm does not follow rigidly: its joints yield.
    assert (v[0] - v[1])[2] == pytest.approx(-6.0 / vehicle.mass * 0.01, rel=0.25)


def test_joints_keep_their_limits_when_a_motor_recovers():
    """The joint was without torque, and is far from its setpoint."""
    scenario = with_faults(JointDegraded(FAULT_S, 0.6, joint=1, remaining=0.0))
    vehicle = VehicleModel.load(scenario)
    log = fly(scenario, ("true_state",), FAULT_S + 1.6)["true_state"]
    q, qdot = log[:, 7:13], log[:, 19:25]
    recovered = round((SETTLE_S + FAULT_S + 0.7) / 0.01)
    assert np.all(q < vehicle.upper + np.radians(0.5))
    assert np.all(q > vehicle.lower - np.radians(0.5))
    assert np.all(np.abs(qdot[recovered:]) < 1.1 * vehicle.velocity)


@pytest.mark.parametrize(("name", "rest_s"), [("hover", 3.0), ("clover_realistic", 0.5)])
def test_it_lands_on_its_feet(name, rest_s):
    """Descends at 0.3 m/s with the arm tucked, until the setpoint is 0.3 m below ground, and rests.

    In wind the rest is short: on the ground with little thrust, the vehicle would tilt more and
    more against the wind.
    """
    scenario = load_scenario(name)
    start = replace(scenario.vehicle, base_position_m=(0.0, 0.0, 1.0))
    tucked = tuple(VehicleModel.load(replace(scenario, vehicle=start)).tucked)
    scenario = replace(scenario, vehicle=replace(start, working_rad=tucked))
    vehicle = VehicleModel.load(scenario)
    under = -vehicle.feet_m - 0.3
    down_s = (1.0 - under) / 0.3
    path = np.array([[0, 0, 1.0], [0, 0, under], [0, 0, under]]).T
    base = PiecewisePolynomial.FirstOrderHold([0, down_s, 100.0], path)
    joints = PiecewisePolynomial.FirstOrderHold([0, 100.0], np.column_stack([tucked, tucked]))
    diagram = make_open_loop(scenario, base, joints)
    context = make_context(diagram, scenario.seed)
    simulator, arm, feet = Simulator(diagram, context), [], []
    plant = multibody_plant(diagram)
    touching = plant.get_contact_results_output_port()
    for k in range(1, round((down_s + rest_s) / 0.02)):
        simulator.AdvanceTo(k * 0.02)
        x = diagram.GetOutputPort("true_state").Eval(context)
        assert rotation_matrix(x[:4])[2, 2] > np.cos(np.radians(10))
        contacts = touching.Eval(plant.GetMyContextFromRoot(context))
        for i in range(contacts.num_point_pair_contacts()):
            info = contacts.point_pair_contact_info(i)
            bodies = {plant.get_body(b).name() for b in (info.bodyA_index(), info.bodyB_index())}
            (arm if bodies - {"base", "world"} else feet).append(bodies)
        assert np.abs(x[7:13] - tucked).max() < 0.1
    assert feet and not arm
    assert x[6] == pytest.approx(-vehicle.feet_m, abs=0.02)
    assert np.linalg.norm(x[4:6]) < 0.1
