"""Limits that are completed."""

import math

import pytest

from aerodrake.mounting.joint import Limits
from aerodrake.mounting.limits import complete_limits
from aerodrake.mounting.loads import joint_loads
from tests.arm_urdfs import joint, link, read, robot


def completed(inner: str, folder, kind: str = "revolute") -> tuple[Limits, list[str]]:
    """Returns the limits of a single joint, and the changes without its name."""
    text = robot(link("a"), link("b"), joint("j", "a", "b", kind, inner))
    arm, changes = complete_limits(read(text, folder).arm, "b")
    assert arm.joints[0].kind == "revolute"
    return arm.joints[0].limits, [change.rpartition(":")[0] for change in changes]


FULL = 'effort="3" velocity="2" drake:acceleration="4"'


@pytest.mark.parametrize(
    ("kind", "given", "expected"),
    [
        ("revolute", 'lower="-1" upper="2"', (-1, 2)),
        ("revolute", "", (-math.pi, math.pi)),
        ("revolute", 'lower="0" upper="0"', None),
        ("revolute", 'lower="2" upper="-1"', (-1, 2)),
        ("revolute", 'lower="5"', (5, 5 + math.pi)),
        ("revolute", 'upper="1"', (-math.pi, 1)),
        ("revolute", 'lower="-180" upper="180"', (-180, 180)),
        ("continuous", "", (-2 * math.pi, 2 * math.pi)),
        ("continuous", 'lower="-1" upper="2"', (-1, 2)),
    ],
)
def test_range(kind, given, expected, tmp_path):
    limits, changes = completed(f"<limit {given} {FULL}/>", tmp_path, kind)
    assert (limits.lower, limits.upper) == (expected or (-math.pi, math.pi))
    assert len(changes) == (given != 'lower="-1" upper="2"')
    assert (limits.effort, limits.velocity, limits.acceleration) == (3, 2, 4)


@pytest.mark.parametrize("inner", ["", '<limit effort="0" velocity="0"/>', '<limit effort="-1"/>'])
def test_missing_limits_follow_the_loads(inner, tmp_path):
    limits, changes = completed(inner, tmp_path)
    arm = read(robot(link("a"), link("b"), joint("j", "a", "b")), tmp_path).arm
    load = joint_loads(arm, list(arm.joints))["j"]
    assert limits.effort == pytest.approx(2 * load.torque + 15 * load.inertia, rel=5e-3)
    assert limits.velocity == 3 and limits.acceleration == 15 and len(changes) == 4


def test_a_weak_motor_accelerates_slowly(tmp_path):
    limits, _ = completed('<limit lower="-1" upper="1" effort="0.02" velocity="1"/>', tmp_path)
    arm = read(robot(link("a"), link("b"), joint("j", "a", "b")), tmp_path).arm
    inertia = joint_loads(arm, list(arm.joints))["j"].inertia
    assert limits.acceleration == pytest.approx(0.02 / inertia, rel=5e-3)


def test_a_light_last_link_has_a_share_of_the_largest_effort(tmp_path):
    limit = '<limit lower="-1" upper="1" effort="40" velocity="1"/>'
    text = robot(
        *map(link, "ab"),
        link("c", 1e-3),
        joint("j", "a", "b", inner=limit),
        joint("k", "b", "c", inner=""),
    )
    arm, _ = complete_limits(read(text, tmp_path).arm, "c")
    assert [joint.limits.effort for joint in arm.joints] == [40, 0.8]
