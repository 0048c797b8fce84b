"""Reading of foreign URDFs: what is left out, and what is refused in one line."""

import pytest

from aerodrake.mounting.arm_urdf import read_arm
from aerodrake.mounting.joint import Limits, Motor
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import ARM, joint, link, read, robot


def refusal(text: str, folder) -> str:
    """Returns the message with which a URDF is refused, without the file."""
    with pytest.raises(BadInput) as caught:
        read(text, folder)
    source, _, message = str(caught.value).partition("arm.urdf: ")
    assert source == f"{folder}/" and message.isprintable()
    return message


def two(inner: str = "", kind: str = "revolute", **names: str) -> str:
    """Returns a URDF of two links and a joint."""
    return robot(link("a"), link("b"), joint("j", "a", "b", kind, inner))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (two().replace('xyz="0.03 0 0.2"', 'xyz="${x} 0 0"'), "expand it with the command `xacro`"),
        (two().replace('name="b"', 'name="$(arg p)b"'), "expand it with the command `xacro`"),
        (two().replace("<axis", "<xacro:axis/><axis"), "expand the macros"),
        (two().replace("0.03 0 0.2", "0,03 0 0.2"), "<origin xyz>: expected 3 numbers"),
        (two().replace("0.2 -0.4 0.6", "0 NaN 0"), "<origin rpy>: expected 3 numbers"),
        (two().replace("rpy=", "rpz="), "expected the attributes xyz and rpy, got 'rpz'"),
        (two().replace("0 2 1", "0 0 0"), "<axis xyz>: expected a vector other than zero"),
        (two().replace('value="0.5"', 'value="-0.5"'), "expected a non-negative number in kg"),
        (two('<limit effort="strong"/>'), "<limit effort>: expected a number, got 'strong'"),
        (two(kind="ball"), "expected a type of revolute, continuous"),
        (two().replace('parent link="a"', 'parent link="aa"'), "expected a link, got 'aa'"),
        (robot(link("a"), link("a")), "expected different names of links, got 'a' 2 times"),
        (robot(link("")), "expected names of all links"),
        (robot(), "expected links, got none"),
        (
            robot(link("a"), link("b"), joint("j", "a", "b"), joint("k", "b", "a")),
            "expected no loop of joints",
        ),
        (
            robot(*map(link, "abc"), joint("j", "a", "c"), joint("k", "b", "c")),
            "expected one joint above 'c', got 2",
        ),
        (two().replace("</robot>", '<drake:joint name="x"/></robot>'), "got <drake:joint>"),
        (two().replace("<robot", "<sdf").replace("</robot", "</sdf"), "whose root is <robot>"),
    ],
)
def test_it_refuses_in_one_line(text, message, tmp_path):
    assert message in refusal(text, tmp_path)


def test_elements_of_other_programs_are_removed_and_named(tmp_path):
    noise = (
        '<gazebo/><gazebo reference="b"/><ros2_control name="x"><joint name="j"/></ros2_control>'
    )
    text = two("<safety_controller/><calibration/>").replace("</robot>", f"{noise}</robot>")
    (sentence,) = read(text, tmp_path).changes
    expected = "<calibration> (1), <gazebo> (2), <ros2_control> (1), <safety_controller> (1)"
    assert sentence.endswith(expected)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "iso-8859-1"])
def test_encodings_comments_and_namespaces(encoding, tmp_path):
    text = ARM.replace("<robot", "<!-- bras à côté ${x} <xacro:if> --><robot xmlns:x='urn:x'")
    declared = encoding.removesuffix("-sig")
    text = text.replace('"1.0"?', f'"1.0" encoding="{declared}"?')
    path = tmp_path / "arm.urdf"
    path.write_bytes(text.encode(encoding))
    assert read_arm(path).arm == read(ARM, tmp_path).arm


def test_infinite_limits_are_none(tmp_path):
    limit = '<limit lower="-inf" upper="Infinity" effort="1e300" velocity="" />'
    assert read(two(limit), tmp_path).arm.joints[0].limits == Limits()


def test_motors_are_read_from_transmissions(tmp_path):
    motor = """<transmission name="t"><type>transmission_interface/SimpleTransmission</type>
    <joint name="j"/><actuator name="m"><mechanicalReduction>7</mechanicalReduction>{}</actuator>
    </transmission></robot>"""
    for inner, expected in (
        ("", None),
        ('<drake:gear_ratio value="50"/><drake:rotor_inertia value="2e-6"/>', Motor(50, 2e-6)),
    ):
        text = two().replace("</robot>", motor.format(inner))
        assert read(text, tmp_path).arm.joints[0].motor == expected


def test_a_frame_becomes_a_link_without_mass(tmp_path):
    frame = '<frame name="grasp" link="b" xyz="0 0 0.1" rpy="0 0 1"/></robot>'
    arm = read(two().replace("</robot>", frame), tmp_path).arm
    assert [joint.name for joint in arm.path("grasp")] == ["j", "grasp_frame"]
    assert arm.link("grasp").mass == 0 and arm.joints[1].origin.xyz == (0, 0, 0.1)


def test_a_joint_may_begin_in_the_world_of_drake(tmp_path):
    arm = read(robot(link("a"), joint("j", "world", "a", "fixed", "")), tmp_path).arm
    assert arm.root == "world" and arm.above["a"].name == "j"
