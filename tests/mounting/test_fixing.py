"""Joints that are fixed, and where."""

import pytest

from aerodrake.mounting.fixing import fix_joints, has_room, rest
from aerodrake.mounting.joint import ArmJoint, Limits, Mimic
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import joint, link, read, robot


@pytest.mark.parametrize(
    ("lower", "upper", "kind", "position"),
    [
        (-1, 1, "revolute", 0),
        (0.3, 1, "revolute", 0.3),
        (-1, -0.2, "prismatic", -0.2),
        (None, None, "prismatic", 0),
        (0.5, None, "prismatic", 0.5),
        (0.3, 1, "continuous", 0),
        (1, -1, "revolute", 0),
    ],
)
def test_a_joint_rests_at_zero_or_the_limit_next_to_it(lower, upper, kind, position):
    limits = Limits(lower, upper)
    assert rest(ArmJoint("j", kind, "a", "b", limits=limits), {}) == position


def test_a_mimic_follows_also_in_a_chain_and_a_loop():
    lead = ArmJoint("lead", "prismatic", "a", "b", limits=Limits(0.1, 1))
    second = ArmJoint("second", "prismatic", "a", "c", mimic=Mimic("lead", 2, 0.5))
    third = ArmJoint("third", "prismatic", "a", "d", mimic=Mimic("second", -1, 0))
    joints = {joint.name: joint for joint in (lead, second, third)}
    assert rest(third, joints) == pytest.approx(-0.7)
    own = ArmJoint("own", "prismatic", "a", "b", mimic=Mimic("own", 1, 0))
    assert rest(own, {"own": own}) == 0


def test_equal_limits_fix_a_joint_unless_they_were_left_at_zero():
    for limits, expected in (
        (Limits(0, 0, 0, 0), True),
        (Limits(0, 0), True),
        (Limits(0, 0, 10, 2), False),
        (Limits(1, 1), False),
        (Limits(), True),
        (Limits(0, 1), True),
    ):
        assert has_room(ArmJoint("j", "revolute", "a", "b", limits=limits)) is expected


def test_a_joint_without_room_on_the_chain_is_fixed(tmp_path):
    equal = '<limit lower="0.5" upper="0.5" effort="1" velocity="1"/>'
    text = robot(
        *map(link, "abc"), joint("j", "a", "b", inner=equal), joint("k", "b", "c", "continuous")
    )
    arm, (sentence,) = fix_joints(read(text, tmp_path).arm, "c")
    assert sentence == "joints without room between their limits are fixed at 0.5 rad: j"
    assert [joint.name for joint in arm.moving("c")] == ["k"]


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("floating", "joint j: expected revolute, prismatic or fixed joints, got type floating"),
        ("fixed", "tool: expected revolute joints between 'a' and 'b', got none"),
        ("prismatic", "tool: expected revolute joints between 'a' and 'b', got none"),
    ],
)
def test_arms_without_revolute_joints_are_refused(kind, message, tmp_path):
    arm = read(robot(link("a"), link("b"), joint("j", "a", "b", kind)), tmp_path).arm
    with pytest.raises(BadInput) as caught:
        fix_joints(arm, "b")
    assert str(caught.value) == message
