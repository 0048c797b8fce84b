"""Names that are changed."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.link import ArmLink
from aerodrake.mounting.names import rename, renamed_link


def chain(*names: str) -> ArmTree:
    """Returns an arm of links in a row, whose joints have the names of their children."""
    joints = (
        ArmJoint(below, "revolute", above, below)
        for above, below in zip(names, names[1:], strict=False)
    )
    return ArmTree("arm", tuple(map(ArmLink, names)), tuple(joints))


@pytest.mark.parametrize(
    ("name", "new"),
    [
        ("base", "arm_base"),
        ("tool", "arm_tool"),
        ("world", "arm_world"),
        ("payload", "arm_payload"),
        ("rotor_1_ccw", "arm_rotor_1_ccw"),
        ("upper arm", "upper_arm"),
        ("left/hand", "left_hand"),
        ("robot::link", "robot_link"),
        ("tool0", "tool0"),
        ("base_link", "base_link"),
        ("/base_link", "base_link"),
        ("_bras à", "_bras"),
        ("été", "t"),
        ("é", "unnamed"),
    ],
)
def test_names_of_links(name, new):
    arm = chain("first", name)
    renamed, changes = rename(arm)
    assert renamed.links[1].name == renamed.joints[0].child == renamed_link(arm, name) == new
    assert any(f"{name} to {new}" in change for change in changes) == (name != new)


def test_joints_may_have_names_of_links():
    assert rename(chain("a", "base")).arm.joints[0].name == "base"


def test_a_joint_may_not_have_the_name_of_the_mount():
    arm = rename(chain("mount", "mount_2", "mount")).arm
    assert [joint.name for joint in arm.joints] == ["mount_2", "arm_mount"]
    assert arm.links[0].name == "mount"


def test_joints_may_not_look_like_rotors():
    """Drake makes frames with the names of joints."""
    assert rename(chain("a", "rotor_1")).arm.joints[0].name == "arm_rotor_1"


@given(st.lists(st.text("ab _/é:", min_size=1, max_size=4), min_size=2, max_size=6, unique=True))
def test_names_stay_different_and_the_result_is_final(names):
    arm, _ = rename(chain(*names, "base", "arm_base"))
    links = [link.name for link in arm.links]
    assert len(set(links)) == len(links) and len({j.name for j in arm.joints}) == len(links) - 1
    assert [joint.child for joint in arm.joints] == links[1:]
    assert rename(arm).arm == arm and not rename(arm).changes
