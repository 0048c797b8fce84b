"""Guess of an arm's tool and of the direction in which it points."""

import re

import numpy as np
import pytest

from aerodrake.mounting.tool import Tool
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import frame_link, read, serial_arm


def tool(end: str, folder, wanted: str = "", axes: str = "zxx") -> Tool:
    return Tool.of(read(serial_arm(axes, end=end), folder).arm, wanted)


@pytest.mark.parametrize(
    ("end", "link"),
    [
        (frame_link("ee_link", "link_3") + frame_link("tool0", "link_3"), "tool0"),
        (frame_link("flange", "link_3") + frame_link("left_hand_tcp", "flange"), "left_hand_tcp"),
        (frame_link("marker", "link_3"), "marker"),
        (frame_link("camera_tool0", "link_2") + frame_link("eef", "link_3"), "eef"),
        (frame_link("jaw", "link_3", joint="revolute"), "link_3"),
        (frame_link("left_finger", "link_3", joint="prismatic"), "link_3"),
        (frame_link("wrist_roll_hand", "link_3", joint="revolute"), "wrist_roll_hand"),
        (frame_link("hand_index_flex_1", "link_3", joint="revolute"), "link_3"),
        (frame_link("gripper_controller", "link_3", joint="revolute"), "link_3"),
        (
            frame_link("pad_1", "link_3", joint="revolute")
            + frame_link("pad_2", "link_3", joint="revolute")
            + frame_link("pad_3", "pad_2", joint="revolute"),
            "link_3",
        ),
        ("", "link_3"),
    ],
)
def test_the_link(end, link, tmp_path):
    assert tool(end, tmp_path).link == link


def test_a_sliding_joint_before_the_arm_is_not_a_gripper(tmp_path):
    text = serial_arm("zxx", end=frame_link("tcp", "link_3"))
    text = text.replace('name="joint_1" type="revolute"', 'name="lift" type="prismatic"')
    assert Tool.of(read(text, tmp_path).arm).link == "tcp"


def test_the_end_of_a_link_is_twice_as_far_as_its_centre_of_mass(tmp_path):
    for axes in ("zxx", "zxz"):  # A pitch joint, and a roll joint along the link.
        guessed = tool("", tmp_path, axes=axes)
        assert guessed.position == pytest.approx([0, 0, 0.12]) and guessed.direction[2] == 1


@pytest.mark.parametrize(
    ("xyz", "axes", "direction"),
    [
        ("0 0 0.12", "zxx", (0, 0, 1)),
        ("0 0.1 0", "zxx", (0, 1, 0)),  # Across the last axis: towards the tool.
        ("0.01 0 -0.1", "zxz", (0, 0, -1)),  # Along the last axis, but for an offset.
        ("0.003 0.02 0.1", "zxx", (0, 0.02 / 0.102, 0.1 / 0.102)),
    ],
)
def test_the_direction(xyz, axes, direction, tmp_path):
    guessed = tool(frame_link("tcp", "link_3", xyz), tmp_path, axes=axes)
    assert np.linalg.norm(guessed.direction) == pytest.approx(1)
    assert guessed.direction == pytest.approx(direction, abs=0.21)
    assert guessed.position == pytest.approx([0, 0, 0])


def test_a_tool_on_the_axis_of_the_last_joint_points_away_from_the_joint_before(tmp_path):
    guessed = tool(frame_link("eef", "link_3", "0 0 0"), tmp_path, axes="zxz")
    assert guessed.direction == pytest.approx([0, 0, 1])


def test_a_short_last_link_points_away_from_the_joint_before(tmp_path):
    """Its centre of mass is behind its joint, as that of a flange."""
    end = '<link name="flange"><inertial><origin xyz="0 0 -0.02"/><mass value="0.1"/></inertial>'
    end += '</link><joint name="j" type="revolute"><parent link="link_2"/><child link="flange"/>'
    end += '<origin xyz="0 0 0.12"/><axis xyz="0 0 1"/></joint>'
    guessed = tool(end, tmp_path, axes="xx")
    assert guessed.link == "flange" and guessed.direction == pytest.approx([0, 0, 1])
    assert not guessed.position.any()


def test_arms_without_masses_end_at_a_frame_or_at_the_end_of_the_geometry(tmp_path):
    bare = re.sub("<inertial>.*?</inertial>", "", serial_arm("zxz"), flags=re.DOTALL)
    guessed = Tool.of(read(bare, tmp_path).arm)
    assert guessed.link == "link_3" and guessed.position == pytest.approx([0, 0, 0.12])
    frame = bare.replace("</robot>", frame_link("eighth", "link_3") + "</robot>")
    assert Tool.of(read(frame, tmp_path).arm).link == "eighth"


def test_other_trees_of_links_do_not_matter(tmp_path):
    text = serial_arm("zxx").replace("<link ", '<link name="floor"/><link ', 1)
    assert Tool.of(read(text, tmp_path).arm).link == "link_3"


def test_an_arm_without_revolute_joints(tmp_path):
    with pytest.raises(BadInput, match="^expected revolute joints, got none"):
        Tool.of(read(serial_arm("xx", kind="prismatic"), tmp_path).arm)


def test_a_given_link_is_the_tool(tmp_path):
    given = tool(frame_link("tcp", "link_3"), tmp_path, "link_2")
    assert given.link == "link_2" and not given.position.any() and given.reason == "as given"


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("link_33", "tool: expected a link, got 'link_33'; did you mean 'link_3'?"),
        ("link_0", "tool: expected a link with revolute joints above it, got 'link_0'"),
    ],
)
def test_links_that_are_no_tool(wanted, message, tmp_path):
    with pytest.raises(BadInput, match=message.replace("?", r"\?")):
        tool("", tmp_path, wanted)
