"""Conversion of whole arms: kinematics, masses and forces are those of the original."""

import numpy as np
import pytest

from aerodrake.model.vehicle.robot import RobotDescription, make_nominal_plant
from aerodrake.mounting.convert import convert
from aerodrake.mounting.elements import joint_element
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import ARM, plant, pose, read, vehicle

FIXED = {"left": 0.01, "right": -2 * 0.01 + 0.005, "other_joint": 0.0}
"""Positions at which the joints that do not move the tool are fixed."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("arm")


@pytest.fixture(scope="module")
def conversion(folder):
    return convert(read(ARM, folder), "tool")


@pytest.fixture(scope="module")
def converted(conversion):
    return plant(vehicle(conversion).toxml())


def test_it_keeps_the_kinematics(conversion, converted):
    original = plant(ARM.replace("<mimic", "<ignored"))
    names = {"base": "arm_base", "tool": "arm_tool"}
    for q in np.random.default_rng(0).uniform(-2, 2, (5, 3)):
        moving = dict(zip(conversion.joints, q.tolist(), strict=True))
        for tip in ("lower", "tool", "left_finger", "right_finger", "other"):
            expected = pose(original, "base", tip, moving | FIXED)
            actual = pose(converted, "arm_base", names.get(tip, tip), moving)
            assert actual.IsNearlyEqualTo(expected, 1e-12)


def test_it_keeps_the_mass(conversion, converted):
    assert conversion.arm.mass == pytest.approx(0.9 + 0.5 + 0.5 + 0.2 + 2 * 0.02 + 0.3)
    total = converted.CalcTotalMass(converted.CreateDefaultContext())
    assert total - 2 == pytest.approx(conversion.arm.mass)


def test_the_package_reads_it(conversion, folder):
    path = folder / "vehicle.urdf"
    path.write_text(vehicle(conversion).toprettyxml())
    made, _ = make_nominal_plant(RobotDescription.read(str(path)))
    assert made.num_positions() == 7 + 3


def test_it_says_all_that_it_changed(conversion):
    assert conversion.joints == ("turn", "bend", "wrist")
    text = "\n".join(conversion.changes)
    for expected in (
        "link 'world' is removed; the arm begins with 'base', 0.2022 m away from it",
        "prismatic joints are fixed at 0.01 m: left",
        "joints that mimic another are fixed at -0.015 m: right",
        "joints that do not move the tool are fixed at 0 rad: other_joint",
        "continuous joints get the limits -6.283 and 6.283 rad: turn",
        "or effort over the largest inertia: 15 (turn, bend, wrist)",
        "links are renamed: base to arm_base, tool to arm_tool",
    ):
        assert expected in text


def test_scaling_is_exact_in_the_equations_of_motion(folder, conversion, converted):
    length, mass = 0.4, 0.1
    scaled = convert(read(ARM, folder), "tool", length=length, mass=mass)
    small = plant(vehicle(scaled).toxml())
    matrices, torques = [], []
    for made in (converted, small):
        context = made.CreateDefaultContext()
        q = made.GetPositions(context)
        q[7:] = [0.3, -0.7, 1.1]
        made.SetPositions(context, q)
        matrices.append(made.CalcMassMatrix(context)[6:, 6:])
        torques.append(made.CalcGravityGeneralizedForces(context)[6:])
    np.testing.assert_allclose(matrices[1], mass * length**2 * matrices[0], rtol=1e-12)
    np.testing.assert_allclose(torques[1], mass * length * torques[0], rtol=1e-12)
    efforts = [made.GetEffortUpperLimits() for made in (converted, small)]
    np.testing.assert_allclose(efforts[1], mass * length * efforts[0], rtol=1e-12)
    assert scaled.arm.reach("arm_tool") == pytest.approx(length * conversion.arm.reach("arm_tool"))


def test_a_converted_arm_stays_as_it_is(folder, conversion):
    """A second conversion finds nothing to change but what is made for every vehicle."""
    text = vehicle(conversion).toxml()
    again = convert(read(text, folder), "arm_tool", root="arm_base")
    assert again.joints == conversion.joints
    *joints, frame = (joint_element(joint).toxml() for joint in again.arm.joints)
    assert joints == [joint_element(joint).toxml() for joint in conversion.arm.joints]
    assert 'name="tool_frame" type="fixed"' in frame
    assert again.arm.mass == pytest.approx(conversion.arm.mass, rel=1e-11)


def test_errors_name_the_file_or_the_argument(folder):
    floating = read(ARM.replace('"prismatic"', '"floating"'), folder)
    for tool, message in (("tool", "arm.urdf: joint left: expected"), ("tol", "tool: expected")):
        with pytest.raises(BadInput, match=message):
            convert(floating, tool, source="arm.urdf")
