"""Joints of a URDF: each refusal names the joint and its own cause."""

import re

import pytest

from aerodrake.model.vehicle.robot import RobotDescription
from tests.urdfs import HEXAROTOR, changed, refusal

WRIST = 'name="wrist_pitch" type="revolute"'
LIMIT = '<limit lower="-2.0" upper="2.0" effort="1.5" velocity="3" drake:acceleration="15"/>'
MOTORS = "  <!-- ===================== Motors"


def joint(name: str, kind: str, parent: str, child: str) -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>'
    return f'<joint name="{name}" type="{kind}">{ends}</joint>\n{MOTORS}'


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (LIMIT, LIMIT.replace('"1.5"', '"0"'), "wrist_pitch: <limit effort>: .* N m, got '0'"),
        (LIMIT, LIMIT.replace('"1.5"', '"-1"'), "<limit effort>: expected a positive .* got '-1'"),
        (LIMIT, LIMIT.replace('"3"', '"0"'), "joint wrist_pitch: <limit velocity>: .* got '0'"),
        (LIMIT, LIMIT.replace('"3"', '"-3"'), "<limit velocity>: .* in rad/s, got '-3'"),
        (LIMIT, LIMIT.replace('"15"', '"0"'), "<limit drake:acceleration>: .* rad/s.2, got '0'"),
        (LIMIT, LIMIT.replace('effort="1.5"', ""), "missing effort; expected effort in N m$"),
        (LIMIT, LIMIT.replace("drake:acc", "acc"), "did you mean 'drake:acceleration'"),
        (LIMIT, LIMIT.replace('velocity="3" drake:acceleration="15"', ""),
         "<limit>: missing velocity, drake:acceleration; expected velocity in rad/s, drake"),
        (LIMIT, "", "joint wrist_pitch: <limit>: missing lower, upper, effort, velocity, drake:"),
        (LIMIT, LIMIT + LIMIT, "joint wrist_pitch: expected one <limit>, got 2"),
        (LIMIT, LIMIT.replace("-2.0", "3"), "lower below upper, got lower='3' upper='2.0'"),
        (LIMIT, LIMIT.replace("-2.0", "2.0"), "lower below upper, got lower='2.0' upper='2.0'"),
        ('<axis xyz="1 0 0"/>', '<axis xyz="0 0 0"/>', "wrist_pitch: <axis xyz>: .* got '0 0 0'"),
        ('<axis xyz="1 0 0"/>', '<axis xyz="1e-9 0 0"/>', "other than zero, got '1e-9 0 0'"),
        (WRIST, WRIST.replace("revolute", "prismatic"), "wrist_pitch: .* got 'prismatic'"),
        (WRIST, WRIST.replace("revolute", "floating"), "revolute, continuous or fixed, got 'floa"),
        (WRIST, WRIST.replace("revolute", "Revolute"), "wrist_pitch: expected type .* 'Revolute'"),
        (WRIST, 'name="wrist_pitch"', "wrist_pitch: expected type .* got ''"),
        ('<parent link="forearm"/>', "", "wrist_pitch: <parent link>: .* got ''; valid: base"),
        ('<parent link="forearm"/>', '<parent link="fourarm"/>', "did you mean 'forearm'"),
        ('<parent link="forearm"/>', '<parent link="hand"/>', "no loop of joints, .* 'hand'"),
        ('<child link="hand"/>', '<child link="world"/>', "<child link>: .* got 'world'"),
        ('<parent link="base"/>', '<parent link="hand"/>', "joint yaw: expected no loop"),
        ('<parent link="base"/> <child link="shoulder"/>',
         '<parent link="shoulder"/> <child link="base"/>', "joint yaw: expected 'base' to be free"),
        (MOTORS, joint("extra", "fixed", "base", "hand"),
         "joint extra: expected one joint above 'hand', which is below wrist_pitch, too"),
        (MOTORS, '<link name="world"/>' + joint("w", "fixed", "world", "base"),
         "joint w: expected 'base' to be free, without a joint above it"),
        (MOTORS, '<link name="loose"/>' + MOTORS, "link loose: expected joints that connect it"),
        (MOTORS, '<link name="second"/>' + joint("left", "revolute", "base", "second"),
         "joint left: .* in series between 'base' and 'tool', got a branch beside yaw, should"),
        (MOTORS, "<drake:ball_constraint/>" + MOTORS, "got <drake:ball_constraint>"),
        ('name="tool" link="hand"', 'name="tool" link="base"', "revolute joints between .* none"),
        ('<frame name="tool"', '<frame name="tip"', "expected a frame named 'tool', whose origin"),
        ("<type>SimpleTransmission</type>", "<type/>", "wrist_pitch: <type>: .* got ''"),
        ("<type>SimpleTransmission</type>", "", "expected SimpleTransmission, got ''"),
        ("SimpleTransmission", "FourBarTransmission", "got 'FourBarTransmission'"),
        ('<joint name="wrist_pitch"/>', '<joint name="wrist_pich"/>', "did you mean 'wrist_pitch'"),
        ('<joint name="wrist_pitch"/>', "", "transmission: <joint name>: expected a joint, got ''"),
        ('<joint name="wrist_pitch"/>', '<joint name="yaw"/>', "yaw: .* <transmission>, got 2"),
        ('"wrist_pitch_motor"', '"yaw_motor"', "names of actuators, got 'yaw_motor' twice"),
        ('<actuator name="wrist_pitch_motor">', "<actuator>", "with the attribute 'name'"),
    ],
)  # fmt: skip
def test_joints(old, new, message, tmp_path):
    assert re.search(message, refusal(changed(HEXAROTOR, old, new), tmp_path))


def test_a_joint_without_transmission(tmp_path):
    start = HEXAROTOR.rindex("<transmission>")
    end = HEXAROTOR.rindex("</transmission>") + len("</transmission>")
    message = refusal(HEXAROTOR[:start] + HEXAROTOR[end:], tmp_path)
    assert message == "joint wrist_pitch: expected one <transmission>, got none"


def test_fixed_joints_may_have_anything(tmp_path):
    """Neither Drake nor this package reads their axis and limits."""
    fixed = joint("mount", "fixed", "hand", "camera").replace(
        "</joint>", '<axis xyz="0 0 0"/><limit effort="0" lower="0" upper="0"/></joint>'
    )
    text = changed(HEXAROTOR, MOTORS, '<link name="camera"/>' + fixed)
    text = changed(text, '<axis xyz="1 0 0"/>', "<axis/>")
    message = refusal(text, tmp_path)
    assert message == "joint wrist_pitch: <axis xyz>: missing; expected 3 numbers"


@pytest.mark.parametrize(("last", "message"), [("base", ""), ("l3", "no loop of joints")])
def test_long_chains(last, message, tmp_path):
    """Their check takes a time in proportion to their length: with its square, minutes."""
    chain, count = "", 3000
    for i in range(count):
        ends = f'<parent link="{f"l{i + 1}" if i < count - 1 else last}"/><child link="l{i}"/>'
        chain += f'<link name="l{i}"/><joint name="j{i}" type="fixed">{ends}</joint>'
    text = changed(HEXAROTOR, MOTORS, chain + MOTORS)
    if message:
        assert message in refusal(text, tmp_path)
    else:
        (tmp_path / "robot.urdf").write_text(text)
        assert RobotDescription.read(str(tmp_path / "robot.urdf"))
