"""Names of the elements of a URDF in messages."""

from xml.dom.minidom import parseString

import numpy as np
import pytest

from aerodrake.support.urdf_element import attribute, child, misspelled, numbers, owner, text

ROBOT = parseString(
    """<robot>
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"><inertial><mass>1 </mass></inertial>
    <visual><geometry><box size="1 2 3"/></geometry></visual>
    <collision><geometry><sphere radius="1"/></geometry></collision>
    <collision><geometry><capsule radius="1"/></geometry></collision></link>
  <joint name="yaw"><axis xyz="0 0 1"/></joint>
  <transmission name="drive"><joint name="yaw"/><actuator/></transmission>
  <transmission><type/></transmission>
  <frame name="tool"/>
  <gazebo><plugin/></gazebo>
</robot>"""
).documentElement


@pytest.mark.parametrize(
    ("tag", "expected"),
    [
        ("color", "material red"),
        ("mass", "link base"),
        ("box", "link base, visual"),
        ("sphere", "link base, collision 1"),
        ("capsule", "link base, collision 2"),
        ("axis", "joint yaw"),
        ("actuator", "transmission of joint yaw"),
        ("type", "transmission"),
        ("frame", "frame tool"),
        ("plugin", ""),
        ("robot", ""),
    ],
)
def test_owner(tag, expected):
    element = ROBOT if tag == "robot" else ROBOT.getElementsByTagName(tag)[0]
    assert owner(element) == expected


def test_content_of_elements():
    link, joint = child(ROBOT, "link"), child(ROBOT, "joint")
    assert attribute(joint, "axis", "xyz") == "0 0 1"
    assert attribute(joint, "limit", "lower") == ""
    assert text(link.getElementsByTagName("mass")[0]) == "1"
    np.testing.assert_array_equal(numbers(child(joint, "axis"), "xyz", "1 0 0"), [0, 0, 1])
    np.testing.assert_array_equal(numbers(child(joint, "axis"), "rpy", "1 0 0"), [1, 0, 0])
    np.testing.assert_array_equal(numbers(child(joint, "origin"), "xyz", "1 0 0"), [1, 0, 0])


def test_misspelled_names():
    known = ("inertial", "visual", "collision")
    assert misspelled("intertial", known) == "inertial"
    assert misspelled("sensor", known) == misspelled("material", known) == ""
