"""Arms with one to fifteen joints fly, and so does a user's own vehicle."""

import re
from dataclasses import replace
from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.bench.arms import with_joints
from aerodrake.cli import main
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import ScenarioError

DIAGRAMS = Path(__file__).parents[1] / "diagrams"
ARM4 = DIAGRAMS / "clover_arm4.yaml"


def test_four_joints_below_six_rotors_fly_their_own_clover():
    scenario = load_scenario(str(ARM4))
    error = summarize(scenario, FlightSimulation(scenario).fly())["error"]
    assert error["lap_mean_m"] < 1e-4 and error["max_m"] < 5e-4


def test_the_vehicle_model_matches_the_urdf():
    """Compared with Drake's own reading of the file."""
    vehicle = VehicleModel.load(load_scenario(str(ARM4)))
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(DIAGRAMS / "hexarotor_arm4.urdf"))
    plant.Finalize()
    assert vehicle.joints == plant.num_actuators() == 4 and len(vehicle.rotors.names) == 6
    assert vehicle.mass == pytest.approx(plant.CalcTotalMass(plant.CreateDefaultContext()))
    for ours, drakes in (
        (vehicle.lower, plant.GetPositionLowerLimits()),
        (vehicle.upper, plant.GetPositionUpperLimits()),
        (vehicle.velocity, plant.GetVelocityUpperLimits()),
        (vehicle.acceleration, plant.GetAccelerationUpperLimits()),
        (vehicle.effort, plant.GetEffortUpperLimits()),
    ):
        assert ours.tolist() == drakes[-4:].tolist()


def changed(tmp_path, change) -> str:
    """Writes a scenario whose URDF has its text changed, and returns its path."""
    (tmp_path / ARM4.name).write_text(ARM4.read_text())
    urdf = (DIAGRAMS / "hexarotor_arm4.urdf").read_text()
    (tmp_path / "hexarotor_arm4.urdf").write_text(change(urdf))
    return str(tmp_path / ARM4.name)


def reversed_blocks(tag: str, urdf: str) -> str:
    """Returns the URDF with the elements of a tag in the opposite order."""
    found = re.findall(rf"  <{tag}[ >].*?\n  </{tag}>\n", urdf, re.DOTALL)
    assert len(found) == 4
    start = urdf.index(found[0])
    for block in found:
        urdf = urdf.replace(block, "")
    return urdf[:start] + "".join(reversed(found)) + urdf[start:]


def with_wrist(urdf: str, old: str, new: str) -> str:
    """Returns the URDF with its last joint changed."""
    start = urdf.index('<joint name="wrist_pitch"')
    assert old in urdf[start:]
    return urdf[:start] + urdf[start:].replace(old, new, 1)


def test_joints_are_in_the_order_of_the_chain(tmp_path):
    """In any order in the file."""
    path = changed(tmp_path, lambda urdf: reversed_blocks("joint", urdf))
    vehicle, ours = (
        VehicleModel.load(load_scenario(path)),
        VehicleModel.load(load_scenario(str(ARM4))),
    )
    assert vehicle.joint_names == ours.joint_names
    assert vehicle.effort.tolist() == ours.effort.tolist()
    assert vehicle.lower.tolist() == ours.lower.tolist()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda urdf: reversed_blocks("transmission", urdf),
            "transmissions in the order of the joints, yaw, shoulder_pitch, elbow_pitch, wrist",
        ),
        (
            lambda urdf: urdf.replace('<parent link="forearm"/>', '<parent link="base"/>'),
            "joint yaw: expected all moving joints in series .* a branch beside wrist_pitch",
        ),
        (
            lambda urdf: with_wrist(urdf, 'type="revolute"', 'type="prismatic"'),
            "joint wrist_pitch: expected type revolute, continuous or fixed, got 'prismatic'",
        ),
        (
            lambda urdf: with_wrist(urdf, 'lower="-2.0" upper="2.0"', ""),
            "hexarotor_arm4.urdf: joint wrist_pitch: <limit>: missing lower, upper; expected",
        ),
        (
            lambda urdf: with_wrist(urdf, "</joint>", '<mimic joint="elbow_pitch"/></joint>'),
            "hexarotor_arm4.urdf: joint wrist_pitch: expected no <mimic>",
        ),
        (
            lambda urdf: urdf.replace('name="tool" link="hand"', 'name="tool" link="forearm"'),
            "joint wrist_pitch: expected .* a branch beside yaw, shoulder_pitch, elbow_pitch",
        ),
    ],
)
def test_other_arms_are_refused(change, message, tmp_path):
    with pytest.raises(ScenarioError, match=message):
        VehicleModel.load(load_scenario(changed(tmp_path, change)))


@pytest.mark.parametrize("joints", [*range(1, 11), 15])
def test_any_number_of_joints_flies_the_clover(joints, tmp_path):
    """One second of hover and three of clover; with one joint the base does most of the motion."""
    scenario = replace(load_scenario("clover"), settle_s=1.0, duration=3.0)
    scenario = with_joints(scenario, joints, tmp_path / "arm.urdf")
    error = summarize(scenario, FlightSimulation(scenario).fly())["error"]
    assert error["max_m"] < (1e-3 if joints == 1 else 2e-4)


def test_a_continuous_joint_with_limits_is_accepted(tmp_path):
    path = changed(tmp_path, lambda u: with_wrist(u, 'type="revolute"', 'type="continuous"'))
    vehicle, ours = (
        VehicleModel.load(load_scenario(path)),
        VehicleModel.load(load_scenario(str(ARM4))),
    )
    assert vehicle.joint_names == ours.joint_names
    assert vehicle.lower.tolist() == ours.lower.tolist()


def test_a_joint_without_limits_is_refused_by_any_type_name(tmp_path):
    def turns_for_ever(urdf):
        urdf = with_wrist(urdf, 'type="revolute"', 'type="continuous"')
        return with_wrist(urdf, 'lower="-2.0" upper="2.0" ', "")

    with pytest.raises(ScenarioError, match="wrist_pitch: <limit>: missing lower, upper"):
        VehicleModel.load(load_scenario(changed(tmp_path, turns_for_ever)))


def test_commands_accept_its_scenario(tmp_path, capsys):
    short = ["--duration", "0.2", "--set", "settle_s=0.1", "--out", str(tmp_path / "run")]
    assert main(["run", str(ARM4), *short]) == 0
    assert "clover_arm4: completed" in capsys.readouterr().out
    again = tmp_path / "run" / "scenario.yaml"
    assert load_scenario(str(again)).vehicle.working_rad == (0.0, -0.2, 1.7, -1.0)
    assert main(["run", str(again), "--quiet", "--out", str(tmp_path / "again")]) == 0
