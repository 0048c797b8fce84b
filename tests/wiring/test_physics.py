"""Physics and plant: their ports, forces, poses and wind, and replacements of them."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.gallery.graph import systems_by_name
from aerodrake.model.low_level.thrust_allocation import trim_thrust
from aerodrake.scenario import Clover, Payload, Rates, Scenario, Wind
from aerodrake.station import make_context, make_station
from aerodrake.support.errors import BadInput
from aerodrake.wiring.physics import make_physics
from aerodrake.wiring.plant import make_plant
from aerodrake.wiring.replacements import Replacements
from tests.robots import at

YourPlant = runpy.run_path(str(Path(__file__).parents[2] / "diagrams" / "your_plant.py"))[
    "YourPlant"
]
JOINTS, ROTORS = 6, 4
STATE, FORCE = 13 + 2 * JOINTS, 6 + JOINTS
SHORT = Scenario(duration=0.3, settle_s=0.1, reference=Clover(start_s=0.2))
BREEZE = Wind(velocity_m_s=(1.0, 0.0, 0.0), gust_m_s=(0.5, 0.5, 0.5))


def ports(system, kind: str) -> dict[str, int]:
    """Returns the sizes of inputs or outputs by name; that of an abstract port is 0."""
    count = getattr(system, f"num_{kind}_ports")()
    every = map(getattr(system, f"get_{kind}_port"), range(count))
    return {port.get_name(): port.size() for port in every}


def test_ports_of_physics(scenario, vehicle):
    physics = make_physics(scenario, vehicle)
    inputs = {"thrust_command": ROTORS, "joint_torque": JOINTS, "external_force": FORCE}
    assert ports(physics, "input") == inputs
    outputs = {"true_state": STATE, "thrust": ROTORS, "body_poses": 0}
    assert ports(physics, "output") == outputs | {"wind_velocity": 3, "wind_force": 3}


def test_ports_of_the_plant(scenario, vehicle):
    plant = make_plant(scenario, vehicle)
    inputs = {"thrust": ROTORS, "joint_torque": JOINTS, "generalized_force": FORCE}
    assert ports(plant, "input") == inputs
    assert ports(plant, "output") == {"state": STATE, "body_poses": 0}


class Physics:
    """The physics alone, with constant inputs."""

    def __init__(self, scenario, vehicle, external_force, seed=0):
        self.system = make_physics(scenario, vehicle)
        self.context = make_context(self.system, seed)
        for name, value in (
            ("thrust_command", trim_thrust(vehicle, scenario.vehicle.rotor)),
            ("joint_torque", vehicle.trim_torque),
            ("external_force", external_force),
        ):
            self.system.GetInputPort(name).FixValue(self.context, value)

    def advance(self, time_s: float) -> None:
        Simulator(self.system, self.context).AdvanceTo(time_s)

    def output(self, name: str):
        return self.system.GetOutputPort(name).Eval(self.context)


def test_an_external_force_accelerates_by_newtons_law(scenario, vehicle):
    """In the first step from trim: M v' = F, with Drake's mass matrix; F = m a for the whole."""
    force = np.array([0.1, -0.2, 0.05, 2.0, -3.0, 5.0, 0.05, 0.1, -0.02, 0.01, 0.02, -0.01])
    step = scenario.rates.plant_step_s
    physics = Physics(scenario, vehicle, force)
    physics.advance(step)
    v = physics.output("true_state")[-FORCE:]
    plant, context = vehicle.plant, at(vehicle.plant, vehicle.trim_state)
    M = plant.CalcMassMatrix(context)
    # Damping of the joints acts implicitly: it is that of the new velocity.
    damped = M + step * np.diag([*np.zeros(6), *vehicle.joint_damping])
    np.testing.assert_allclose(v / step, np.linalg.solve(damped, force), rtol=1e-9, atol=1e-9)
    plant.SetPositionsAndVelocities(context, [*vehicle.trim_state[: 7 + JOINTS], *v])
    climb = plant.CalcCenterOfMassTranslationalVelocityInWorld(context) / step
    np.testing.assert_allclose(climb, force[3:6] / vehicle.mass, atol=1e-9)


def test_body_poses_are_those_of_the_kinematics(scenario, vehicle):
    """World first, then the links in the order of the vehicle's plant, and the payload last."""
    loaded = replace(scenario, payload=Payload(mass_kg=0.3))
    physics = Physics(loaded, vehicle, np.full(FORCE, 0.3))
    physics.advance(0.05)
    poses, x = physics.output("body_poses"), physics.output("true_state")
    plant, context = vehicle.plant, at(vehicle.plant, x)
    bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
    assert len(poses) == plant.num_bodies() + 1 and bodies[0].name() == "world"
    for body in bodies:
        expected = plant.EvalBodyPoseInWorld(context, body)
        assert poses[body.index()].IsNearlyEqualTo(expected, 1e-12)
    tool = plant.GetFrameByName("tool").CalcPoseInWorld(context)
    assert poses[-1].IsNearlyEqualTo(tool, 1e-12)


def test_wind_velocity_is_the_mean_and_the_gust(scenario, vehicle):
    for wind in (Wind(), replace(BREEZE, gust_m_s=(0.0, 0.0, 0.0)), BREEZE):
        physics = Physics(replace(scenario, wind=wind), vehicle, np.zeros(FORCE), seed=3)
        physics.advance(0.0501)
        gust = physics.output("wind_velocity") - wind.velocity_m_s
        assert np.all(np.abs(gust) <= 5 * np.array(wind.gust_m_s))
        assert np.array_equal(gust != 0, np.array(wind.gust_m_s) != 0)


def test_a_robot_without_collision_geometry_has_no_scene_graph(tmp_path, scenario, vehicle):
    description = vehicle.description
    document = description.document.cloneNode(deep=True)
    for element in document.getElementsByTagName("collision"):
        element.parentNode.removeChild(element)
    ghost = replace(vehicle, description=replace(description, document=document))
    plant = make_plant(scenario, ghost)
    assert sorted(systems_by_name(plant)) == ["multibody_plant", "plant", "propellers"]
    assert "scene_graph" in systems_by_name(make_plant(scenario, vehicle))


def flown(scenario=SHORT, **by_name):
    return FlightSimulation(scenario, Replacements(by_name)).fly()


@pytest.fixture(scope="module")
def default():
    return flown()


def test_a_plant_of_ones_own_flies(default, vehicle):
    def make(packaged):
        return YourPlant(vehicle, SHORT.vehicle.rotor.torque_ratio_m, SHORT.rates.plant_step_s)

    log = flown(plant=make)
    assert log.exit_reason == "completed"
    np.testing.assert_allclose(log["p_B_m"], default["p_B_m"], atol=1e-5)
    np.testing.assert_allclose(log["q_rad"], default["q_rad"], atol=1e-3)
    assert not np.array_equal(log["q_rad"], default["q_rad"])
    station = make_station(SHORT, Replacements({"plant": make}))
    assert "body_poses" not in ports(station, "output")


def test_a_plant_with_another_step_flies(default, vehicle):
    fine = replace(SHORT, rates=replace(Rates(), plant_step_s=0.00025))
    log = flown(plant=lambda packaged: make_plant(fine, vehicle))
    assert log.exit_reason == "completed"
    difference = np.abs(log["p_B_m"] - default["p_B_m"]).max()
    assert 0 < difference < 0.03 * np.ptp(default["p_B_m"], axis=0).max()


def test_physics_is_replaced_as_a_whole(vehicle):
    windy = replace(SHORT, wind=BREEZE)
    log = flown(physics=lambda packaged: make_physics(windy, vehicle))
    expected = flown(windy)
    for key in ("p_B_m", "q_rad", "wind_force_n", "thrust_n"):
        np.testing.assert_array_equal(log[key], expected[key])


class Still(LeafSystem):
    """Physics of a vehicle at rest: thrusts follow the commands, and nothing moves."""

    def __init__(self, vehicle):
        super().__init__()
        command = self.DeclareVectorInputPort("thrust_command", ROTORS)
        self.DeclareVectorInputPort("joint_torque", JOINTS)
        self.DeclareVectorInputPort("external_force", FORCE)
        self.DeclareStateOutputPort("true_state", self.DeclareDiscreteState(vehicle.trim_state))
        self._command = command
        self.DeclareVectorOutputPort("thrust", ROTORS, self._calc, {command.ticket()})

    def _calc(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._command.Eval(context))


def test_outputs_other_than_state_and_thrust_are_optional(vehicle):
    log = flown(physics=lambda packaged: Still(vehicle))
    assert log.time_s[-1] == pytest.approx(SHORT.duration)
    np.testing.assert_array_equal(log["p_B_m"], [vehicle.p_B] * len(log["p_B_m"]))
    np.testing.assert_array_equal(log["wind_force_n"], np.zeros_like(log["p_B_m"]))


class Misnamed(LeafSystem):
    """Plant with names and sizes of ports that do not all match."""

    def __init__(self, inputs: dict[str, int], outputs: dict[str, int]):
        super().__init__()
        for name, size in inputs.items():
            self.DeclareVectorInputPort(name, size)
        for name, size in outputs.items():
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(size))


INPUTS = {"thrust": ROTORS, "joint_torque": JOINTS, "generalized_force": FORCE}


@pytest.mark.parametrize(
    ("inputs", "outputs", "message"),
    [
        (
            INPUTS | {"joint_torques": JOINTS},
            {"state": STATE},
            "no signal for its input port 'joint_torques'; did you mean 'joint_torque'? "
            "(valid: generalized_force, joint_torque, thrust)",
        ),
        (
            {"thrust": ROTORS, "joint_torque": JOINTS},
            {"state": STATE},
            "expected an input port 'generalized_force' of size 12; valid: joint_torque, thrust",
        ),
        (
            INPUTS,
            {"states": STATE},
            "expected an output port 'state' of size 25; did you mean 'states'? (valid: states)",
        ),
        (INPUTS, {"state": 13}, "expected an output port 'state' of size 25, got size 13"),
    ],
)
def test_a_plant_that_does_not_fit_is_refused(inputs, outputs, message):
    with pytest.raises(BadInput) as error:
        make_station(SHORT, Replacements({"plant": lambda packaged: Misnamed(inputs, outputs)}))
    assert str(error.value) == f"replacements: plant: {message}"
