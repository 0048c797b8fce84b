"""Vehicle model compared with its URDF's XML and a separate plant; bad files."""

import dataclasses
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce, MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint

import aerodrake.model.vehicle.vehicle as module
from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle.robot import BASE_FRAME, TOOL_FRAME, RobotDescription, add_robot
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Rotor, Scenario
from aerodrake.support.errors import BadInput

URDF = Path(module.__file__).parents[2] / "robots" / "quadrotor_arm6.urdf"
ACCELERATION = "{https://drake.mit.edu}acceleration"


def floating_plant(robot: str, time_step: float = 0.0, gravity: bool = True) -> MultibodyPlant:
    plant = MultibodyPlant(time_step)
    add_robot(plant, RobotDescription.read(robot))
    if not gravity:
        plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    plant.Finalize()
    return plant


@pytest.fixture(scope="module")
def xml() -> ElementTree.Element:
    return ElementTree.parse(URDF).getroot()


def numbers(text: str) -> np.ndarray:
    return np.array([float(word) for word in text.split()])


def test_size_of_the_packaged_vehicle(vehicle):
    assert vehicle.joints == 6
    assert vehicle.mass == pytest.approx(3.8)
    np.testing.assert_allclose(vehicle.p_O, [0, 0.2, -0.3], atol=1e-6)
    np.testing.assert_allclose(vehicle.p_E, [0, 0.2, 1.2], atol=1e-6)


def test_joints_and_limits_match_the_urdf(vehicle, xml):
    joints = xml.findall("joint")
    limits = [joint.find("limit") for joint in joints]
    assert vehicle.joint_names == tuple(joint.get("name") for joint in joints)
    for values, attribute in (
        (vehicle.lower, "lower"),
        (vehicle.upper, "upper"),
        (vehicle.velocity, "velocity"),
        (vehicle.effort, "effort"),
        (vehicle.acceleration, ACCELERATION),
    ):
        np.testing.assert_array_equal(values, [float(limit.get(attribute)) for limit in limits])


def test_rotors_match_the_urdf(vehicle, xml):
    frames = [f for f in xml.findall("frame") if f.get("name").startswith("rotor_")]
    assert vehicle.rotors.names == tuple(f.get("name") for f in frames)
    np.testing.assert_array_equal(vehicle.rotors.p_B, [numbers(f.get("xyz")) for f in frames])
    np.testing.assert_array_equal(vehicle.rotors.spin, [1, -1, 1, -1])


def test_inertia_is_the_sum_over_bodies(scenario, vehicle, xml):
    """Masses and inertias from the XML, composed by the parallel-axis theorem."""
    plant = floating_plant(scenario.vehicle.robot)
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, vehicle.trim_state[: plant.num_positions()])
    masses, centres, inertias = [], [], []
    for link in xml.findall("link"):
        inertial = link.find("inertial")
        pose = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(link.get("name")))
        R, i = pose.rotation().matrix(), inertial.find("inertia")
        xx, yy, zz, xy, xz, yz = (
            float(i.get(key)) for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        )
        assert inertial.find("origin").get("rpy") is None
        masses.append(float(inertial.find("mass").get("value")))
        centres.append(pose @ numbers(inertial.find("origin").get("xyz")))
        inertias.append(R @ [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]] @ R.T)
    total = sum(masses)
    middle = np.average(centres, axis=0, weights=masses)
    composite = np.zeros((3, 3))
    for m, c, inertia in zip(masses, np.subtract(centres, middle), inertias, strict=True):
        composite += inertia + m * (c @ c * np.eye(3) - np.outer(c, c))
    assert vehicle.mass == pytest.approx(total)
    np.testing.assert_allclose(vehicle.inertia, composite, atol=1e-12)


def test_arm_inertia_is_torque_over_acceleration(scenario, vehicle):
    """A unit torque on one joint of the floating vehicle at rest."""
    plant = floating_plant(scenario.vehicle.robot, gravity=False)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, vehicle.trim_state)
    M = plant.CalcMassMatrix(context)
    for torque in np.eye(vehicle.joints):
        acceleration = np.linalg.solve(M, np.concatenate([np.zeros(6), torque]))[6:]
        np.testing.assert_allclose(vehicle.arm_inertia @ acceleration, torque, atol=1e-9)


def test_mixer_is_the_rotors_wrench_about_the_base(vehicle):
    thrust = np.array([1.0, 2.0, 3.0, 4.0])
    forces = np.outer(thrust, [0, 0, 1])
    torque = np.cross(vehicle.rotors.p_B, forces).sum(axis=0)
    torque[2] -= 0.02 * (vehicle.rotors.spin @ thrust)
    wrench = vehicle.rotors.mixer(0.02) @ thrust
    np.testing.assert_allclose(wrench, [thrust.sum(), *torque], atol=1e-14)


def test_trim_is_an_equilibrium(scenario, vehicle):
    """With trim thrusts at the rotors and trim torques in the joints, nothing accelerates."""
    plant = floating_plant(scenario.vehicle.robot)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, vehicle.trim_state)
    thrust = allocate(ThrustAllocation.make(vehicle, Rotor()), vehicle.trim_wrench)
    forces = []
    for p, spin, f in zip(vehicle.rotors.p_B, vehicle.rotors.spin, thrust, strict=True):
        force = ExternallyAppliedSpatialForce()
        force.body_index = plant.GetBodyByName(BASE_FRAME).index()
        force.p_BoBq_B = p
        drag = -spin * Rotor().torque_ratio_m * f
        force.F_Bq_W = SpatialForce(tau=[0, 0, drag], f=[0, 0, f])
        forces.append(force)
    plant.get_applied_spatial_force_input_port().FixValue(context, forces)
    plant.get_actuation_input_port().FixValue(context, vehicle.trim_torque)
    acceleration = plant.get_generalized_acceleration_output_port().Eval(context)
    np.testing.assert_allclose(acceleration, 0, atol=1e-9)


def test_per_joint_values(vehicle):
    np.testing.assert_array_equal(vehicle.per_joint((2.0,), "mpc.w_3_joints"), [2] * 6)
    values = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    np.testing.assert_array_equal(vehicle.per_joint(values, "mpc.w_3_joints"), values)
    for wrong in ((), (1.0, 2.0)):
        with pytest.raises(BadInput, match=r"mpc\.w_3_joints: expected 1 value, or 6"):
            vehicle.per_joint(wrong, "mpc.w_3_joints")


def drift_in_free_flight(time_step: float) -> np.ndarray:
    """(3,) changes within 1 s of energy and of angular and linear momentum, over their size.

    Momenta are about the world's origin; energy is that of links and of rotors behind gears.
    """
    plant = floating_plant(str(URDF), time_step, gravity=False)
    context = plant.CreateDefaultContext()
    for i in plant.GetJointIndices():
        if isinstance(plant.get_joint(i), RevoluteJoint):
            plant.get_joint(i).SetDamping(context, 0.0)
    rng = np.random.default_rng(3)
    quaternion = rng.normal(size=4)
    q = np.concatenate([quaternion / np.linalg.norm(quaternion), rng.normal(size=3)])
    arm = [0.3, 0.2, 0.8, -0.4, 0.5, 0.1]
    v = np.concatenate([rng.normal(size=6), rng.uniform(-1, 1, len(arm))])
    plant.SetPositionsAndVelocities(context, np.concatenate([q, arm, v]))
    plant.get_actuation_input_port().FixValue(context, np.zeros(len(arm)))

    def invariants() -> tuple[np.ndarray, ...]:
        v = plant.GetVelocities(context)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, np.zeros(3))
        energy = np.array([v @ plant.CalcMassMatrix(context) @ v / 2])
        return energy, momentum.rotational(), momentum.translational()

    before = invariants()
    for _ in range(round(1 / time_step)):
        plant.ExecuteForcedEvents(context)
    angles = plant.GetPositions(context)[7:]
    lower, upper = plant.GetPositionLowerLimits()[7:], plant.GetPositionUpperLimits()[7:]
    assert np.all((angles > lower) & (angles < upper))  # Joint limits would dissipate energy.
    return np.array(
        [
            np.linalg.norm(new - old) / np.linalg.norm(old)
            for old, new in zip(before, invariants(), strict=True)
        ]
    )


def test_energy_and_momentum_are_conserved_in_free_flight():
    """To first order: half the step, half the drift."""
    coarse, fine = drift_in_free_flight(1e-3), drift_in_free_flight(0.5e-3)
    assert np.all(coarse < 2e-3)
    np.testing.assert_allclose(coarse / fine, 2, rtol=0.1)


def with_robot(scenario: Scenario, robot: object, **changes) -> Scenario:
    changed = dataclasses.replace(scenario.vehicle, robot=str(robot), **changes)
    return dataclasses.replace(scenario, vehicle=changed, source="flight.yaml")


def test_reads_a_urdf_by_its_path(scenario, vehicle):
    other = VehicleModel.load(with_robot(scenario, URDF))
    assert other.joint_names == vehicle.joint_names
    np.testing.assert_array_equal(other.inertia, vehicle.inertia)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('<frame name="tool"', '<frame name="tip"', "'tool'"),
        ('<frame name="rotor_4_cw"', '<frame name="motor_4_cw"', r"four or more frames rotor_"),
        ('<frame name="rotor_4_cw"', '<frame name="rotor_4"', r"rotor_4: .* ends in _ccw or _cw"),
        ('name="rotor_4_cw" link="base"', 'name="rotor_4_cw" link="gripper"', "rotor_"),
        ('xyz="0.329 -0.329 0.05" rpy="0 0 0"', 'xyz="0.3 -0.3 0" rpy="0.5 0 0"', "z axis"),
        (' effort="1.5"', "", "effort"),
        (' velocity="3"', "", "velocity"),
        (' drake:acceleration="15"', "", "drake:acceleration"),
        (' upper="3.14159265"', "", "joint wrist_roll: <limit>: missing upper"),
        (' lower="-3.14159265"', "", "joint wrist_roll: <limit>: missing lower"),
        ('type="revolute"', 'type="prismatic"', "revolute"),
        ('<joint name="wrist_roll"/>', '<joint name="wrist_pitch"/>', "transmission"),
        ('<link name="base">', '<link name="body">', "."),
        ("</robot>", "", "cannot be parsed"),
    ],
)
def test_defects_of_the_robot_are_reported_with_its_file(scenario, tmp_path, old, new, expected):
    text = URDF.read_text()
    assert old in text
    # Changes the last match.
    before, _, after = text.rpartition(old)
    robot = tmp_path / "robot.urdf"
    robot.write_text(before + new + after)
    with pytest.raises(BadInput, match=expected) as caught:
        VehicleModel.load(with_robot(scenario, robot))
    assert str(caught.value).startswith(f"flight.yaml: vehicle.robot: {robot}: ")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "robot",
    [
        "missing.urdf",
        "package://aerodrake/robots/missing.urdf",
        "package://nowhere/robot.urdf",
        "/",
        "x" * 300 + ".urdf",
        "a\0b.urdf",
        "",
    ],
    ids=["file", "in_package", "package", "folder", "too_long", "null", "empty"],
)
def test_no_such_robot(scenario, robot):
    with pytest.raises(BadInput) as caught:
        VehicleModel.load(with_robot(scenario, robot))
    assert robot.partition("\0")[0] in str(caught.value)


@pytest.mark.parametrize("name", ["notes.txt", "notes.urdf", "robot.xml"])
@pytest.mark.parametrize("text", ["", "no robot", "<robot/>", "<mujoco/>"])
def test_not_a_robot(scenario, tmp_path, name, text):
    robot = tmp_path / name
    robot.write_text(text)
    with pytest.raises(BadInput, match=name):
        VehicleModel.load(with_robot(scenario, robot))


@pytest.mark.parametrize(
    ("working", "expected"),
    [
        ((0.0,) * 5, r"vehicle\.working_rad: expected 6 angles in rad, .*, got 5"),
        ((), r"vehicle\.working_rad: expected 6 angles in rad, .*, got 0"),
        (
            (0.0, 0.0, 2.7, 0.0, 0.0, 0.0),
            r"vehicle\.working_rad\[2\]: expected elbow_pitch in \[-2\.618, 2\.618\] rad, got 2\.7",
        ),
    ],
)
def test_working_configuration_that_does_not_fit(scenario, working, expected):
    with pytest.raises(BadInput, match="^flight.yaml: " + expected):
        VehicleModel.load(with_robot(scenario, scenario.vehicle.robot, working_rad=working))


def test_initial_position_of_the_tool(scenario, vehicle):
    plant = floating_plant(scenario.vehicle.robot)
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, vehicle.trim_state)
    tool = plant.GetFrameByName(TOOL_FRAME).CalcPoseInWorld(context).translation()
    np.testing.assert_allclose(tool, vehicle.p_E, atol=1e-12)
