"""Links of a URDF: inertias that are not physical, names, geometry."""

import re

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from pydrake.multibody.plant import MultibodyPlant
from scipy.spatial.transform import Rotation

from aerodrake.model.vehicle.robot import RobotDescription, add_robot
from tests.urdfs import HEXAROTOR, changed, refusal

HAND = 'ixx="5e-5" iyy="5e-5" izz="4e-5" ixy="0" ixz="0" iyz="0"'


def with_moments(moments: list[float]) -> str:
    """Returns the hexarotor whose hand has other moments and products of inertia, xx to yz."""
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    given = " ".join(f'{n}="{x!r}"' for n, x in zip(names, moments, strict=True))
    return changed(HEXAROTOR, HAND, given)


@pytest.mark.parametrize(
    ("moments", "principal"),
    [
        ([5e-5, 5e-5, 40e-5, 0, 0, 0], "5e-05, 5e-05, 0.0004"),
        ([-5e-5, 5e-5, 4e-5, 0, 0, 0], "-5e-05, 4e-05, 5e-05"),
        ([5e-5, 5e-5, 4e-5, 1e-3, 0, 0], "-0.00095, 4e-05, 0.00105"),
        ([1e-5, 0, 0, 0, 0, 0], "0, 0, 1e-05"),
        ([5e-5, 5e-5, 0, 0, 0, 0], "0, 5e-05, 5e-05"),
        ([0, 0, 0, 0, 0, 0], "0, 0, 0"),
    ],
    ids=["triangle", "negative", "product", "line", "rod", "point"],
)
def test_inertias_that_are_not_physical(moments, principal, tmp_path):
    message = refusal(with_moments(moments), tmp_path)
    assert message.startswith("link hand: <inertia>: expected principal moments")
    assert f"got {principal} kg m^2 from ixx={moments[0]}, " in message


@settings(max_examples=25)
@given(
    a=st.floats(0, 1e-4), b=st.floats(0, 1e-4), slack=st.floats(-0.5, 0.5),
    rpy=st.tuples(*[st.floats(-3, 3)] * 3),
)  # fmt: skip
def test_the_triangle_inequality_in_any_axes(a, b, slack, rpy, tmp_path_factory):
    """Bodies of three point masses on the axes, or with more about one axis than that."""
    assume(abs(slack) > 1e-3 and min(a, b) > 1e-7)
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    inertia = R @ np.diag([a, b, (a + b) * (1 + slack)]) @ R.T
    text = with_moments(
        [float(inertia[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    )
    folder = tmp_path_factory.getbasetemp()
    if slack > 0:
        assert "link hand: <inertia>: expected principal moments" in refusal(text, folder)
    elif (a + b) * (1 + slack) >= abs(a - b) * (1 + 1e-6):
        (folder / "good.urdf").write_text(text)
        plant = MultibodyPlant(0.0)
        add_robot(plant, RobotDescription.read(str(folder / "good.urdf")))
        hand = plant.GetBodyByName("hand").default_spatial_inertia()
        about_centre = hand.Shift(hand.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        np.testing.assert_allclose(about_centre, inertia, atol=1e-12)


def test_frames_and_links_without_mass_are_accepted(tmp_path):
    """CAD programs export a frame as a link of almost no mass, without inertia."""
    frame = changed(HEXAROTOR, HAND, HAND.replace("5e-5", "0").replace("4e-5", "0"))
    frame = changed(frame, MASS, '<mass value="1e-9"/>')
    inertial = re.search(r"<inertial>(?:(?!</inertial>).)*0\.08.*?</inertial>", HEXAROTOR, re.S)[0]
    for text in (frame, changed(HEXAROTOR, inertial, "")):
        (tmp_path / "robot.urdf").write_text(text)
        add_robot(MultibodyPlant(0.0), RobotDescription.read(str(tmp_path / "robot.urdf")))


CYLINDER = '<cylinder radius="0.01" length="0.08"/>'
MASS = '<mass value="0.08"/>'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "</collision>",
            '<drake:proximity_properties><drake:mu_static value="0.1"/><drake:mu_dynamic '
            'value="0.5"/></drake:proximity_properties></collision>',
            "link hand, collision: <drake:proximity_properties>: .* up to mu_static, 0.1, got 0.5",
        ),
        (MASS, "", "link hand: <inertial>: missing <mass>; a link without mass has no <inertial>"),
        (f"<inertia {HAND}/>", "", "link hand: <inertial>: missing <inertia>"),
        (MASS, MASS + MASS, "link hand: expected one <mass>, got 2"),
        ('<link name="hand">', "<link>", "<link>: expected the attribute 'name'"),
        ('<link name="hand">', '<link name="hand" drake_ignore="true">', "no attribute 'drake_ig"),
        ('<link name="hand">', '<link name="forearm">', "links and frames, got 'forearm' 2 times"),
        ('name="tool" link', 'name="hand" link', "names of links and frames, got 'hand' 2 times"),
        ('joint name="elbow_pitch" type', 'joint name="yaw" type', "joints, got 'yaw' 2 times"),
        ('<link name="base">', '<link name="body">', "expected a link named 'base'; valid: body"),
        ('name="tool" link="hand"', 'name="tool" link="hnd"', "frame tool: .* mean 'hand'"),
        ('name="tool" link="hand"', 'name="tool"', "frame tool: .* of a link, got ''"),
        ('member link="hand"', 'member link="hnd"', "<drake:member link>: .* did you mean 'hand'"),
        (CYLINDER, '<cone radius="1"/>', "hand, collision: <geometry>: .* <box>, .* got <cone>"),
        (CYLINDER, "", "link hand, collision: <geometry>: expected one shape, .* got none"),
        (CYLINDER, CYLINDER * 2, "expected one shape, .* got <cylinder> and <cylinder>"),
        (f"<geometry>{CYLINDER}</geometry>", "", "link hand, collision: <geometry>: .* got none"),
        (CYLINDER, '<mesh filename="a.stl"/>', r"in \.obj, \.vtk, \.gltf, got 'a.stl'; convert it"),
        (CYLINDER, '<mesh filename="a.dae"/>', "link hand, collision: <mesh .* got 'a.dae'"),
    ],
)  # fmt: skip
def test_links_and_geometry(old, new, message, tmp_path):
    for name in ("a.stl", "a.dae"):
        (tmp_path / name).touch()
    assert re.search(message, refusal(changed(HEXAROTOR, old, new), tmp_path))


def test_visual_meshes_may_have_other_formats(tmp_path):
    (tmp_path / "a.stl").touch()
    text = HEXAROTOR.replace(CYLINDER, '<mesh filename="a.stl"/>', 1)
    (tmp_path / "robot.urdf").write_text(text)
    RobotDescription.read(str(tmp_path / "robot.urdf"))
