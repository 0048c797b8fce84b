"""Flights of the station with noise, wind, model mismatch and a payload."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.vehicle.robot import TOOL_FRAME, add_robot
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Mismatch, Payload, Scenario, Sensors, Wind
from aerodrake.station import make_context, make_station
from tests.robots import multibody_plant
from tests.trim import hovering


def test_noise_does_not_lift_the_base():
    """Rotors accelerate faster than they slow down, so that noise increases the mean thrust."""
    noisy = Sensors(attitude_noise_rad=0.005)
    log = FlightSimulation(Scenario(settle_s=0.0, duration=8.0, sensors=noisy)).fly()
    offset = log["p_B_m"][300:, 2] - log["p_Bd_m"][300:, 2]
    assert abs(offset.mean()) < 0.003


def test_the_base_tilts_into_a_steady_wind(scenario, vehicle):
    """The thrust balances gravity and drag, and the base's z axis is parallel to it."""
    wind = Wind(velocity_m_s=(3.0, -4.0, 1.0))
    speed = np.sqrt(26.0)
    drag = (0.25 * speed + 0.15) * np.array(wind.velocity_m_s)
    station = make_station(replace(scenario, wind=wind))
    context = make_context(station, 0)
    base, joints = hovering(vehicle)
    station.GetInputPort("base_setpoint").FixValue(context, base)
    station.GetInputPort("joint_setpoint").FixValue(context, joints)
    Simulator(station, context).AdvanceTo(12.0)

    def output(port):
        return station.GetOutputPort(port).Eval(context)

    balance = -drag - [0, 0, -9.81 * vehicle.mass]
    state = split_state(output("true_state"))
    np.testing.assert_allclose(output("wind_force"), drag, atol=1e-4)
    assert output("thrust").sum() == pytest.approx(np.linalg.norm(balance), abs=1e-4)
    np.testing.assert_allclose(state.R_B[:, 2], balance / np.linalg.norm(balance), atol=1e-5)
    np.testing.assert_allclose(output("disturbance")[:3], drag / vehicle.mass, atol=1e-4)
    np.testing.assert_allclose(state.p_B, base[:3], atol=1e-4)


def test_the_sensor_noise_does_not_depend_on_the_wind(scenario):
    noisy = replace(scenario, sensors=Sensors(position_noise_m=0.01))
    draws = []
    for wind in (Wind(), Wind(velocity_m_s=(2.0, 0.0, 0.0), gust_m_s=(1.0, 1.0, 1.0))):
        station = make_station(replace(noisy, wind=wind))
        noise = station.GetSubsystemByName("sensors").GetSubsystemByName("sensor_noise")
        context = noise.GetMyContextFromRoot(make_context(station, 3))
        draws.append(noise.get_output_port().Eval(context))
    np.testing.assert_array_equal(*draws)


def test_the_plant_of_a_default_context_has_the_mismatch(scenario, vehicle):
    station = make_station(replace(scenario, mismatch=Mismatch(mass_scale=1.2)))
    plant = multibody_plant(station)
    context = plant.GetMyContextFromRoot(station.CreateDefaultContext())
    assert plant.CalcTotalMass(context) == pytest.approx(1.2 * vehicle.mass)


def test_a_heavier_plant_is_estimated_as_a_disturbance(vehicle):
    heavy = Mismatch(mass_scale=1.05, inertia_scale=1.05, rotor_lag_scale=1.2, thrust_scale=1.1)
    log = FlightSimulation(Scenario(settle_s=0.0, duration=8.0, mismatch=heavy)).fly()
    assert log["thrust_n"][-1].sum() == pytest.approx(1.05 * vehicle.mass * 9.81, abs=1e-3)
    commanded = (1 + 0.05 / 1.1) * vehicle.mass * 9.81
    assert log["thrust_command_n"][-1].sum() == pytest.approx(commanded, abs=1e-3)
    assert log["disturbance_m_s2"][-1][2] == pytest.approx(-0.05 / 1.1 * 9.81, abs=1e-3)
    assert log.error_m[-1] < 1e-3


@pytest.fixture(scope="module")
def loaded_hover():
    """A hover with a payload of 0.2 kg from the start, until the vehicle is at rest."""
    return FlightSimulation(
        Scenario(settle_s=0.0, duration=10.0, payload=Payload(mass_kg=0.2))
    ).fly()


def test_a_payload_is_lifted_and_the_tool_returns(loaded_hover, vehicle):
    log = loaded_hover
    assert log["thrust_n"][-1].sum() == pytest.approx((vehicle.mass + 0.2) * 9.81, abs=1e-3)
    assert 0.003 < log.error_m.max() < 0.008
    assert log.error_m[log.time_s > 5].max() < 1e-6
    assert log["disturbance_m_s2"][-1][2] == pytest.approx(-0.2 * 9.81 / vehicle.mass, abs=1e-3)


def test_joint_torques_balance_arm_and_payload(loaded_hover, vehicle):
    """Expected are Drake's gravity torque and the payload's weight times the tool's Jacobian."""
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    log = loaded_hover
    plant.SetPositions(
        context, np.concatenate([log[key][-1] for key in ("quaternion", "p_B_m", "q_rad")])
    )
    world, tool = plant.world_frame(), plant.GetFrameByName(TOOL_FRAME)
    J_v = plant.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, tool, np.zeros(3), world, world
    )
    gravity = plant.CalcGravityGeneralizedForces(context) + J_v.T @ [0, 0, -0.2 * 9.81]
    assert np.abs(gravity[6:] + vehicle.trim_torque).max() > 0.3  # The payload's part.
    np.testing.assert_allclose(log["joint_torque_n_m"][-1], -gravity[6:], atol=1e-3)
