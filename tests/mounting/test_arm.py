"""Typed trees of arms."""

import math

import pytest

from tests.arm_urdfs import ARM, plant, pose, read


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    return read(ARM, tmp_path_factory.mktemp("arm")).arm


def test_poses_are_those_of_drake(arm):
    q = {"turn": 0.4, "bend": -1.0, "wrist": 2.0, "left": 0.03}
    made, poses = plant(ARM.replace("<mimic", "<ignored")), arm.poses(q)
    for name in ("base", "upper", "left_finger", "other"):
        assert poses[name].IsNearlyEqualTo(pose(made, "world", name, q), 1e-12)


def test_the_tree(arm):
    assert arm.root == "world" and arm.tips() == ["left_finger", "right_finger", "other"]
    assert [joint.name for joint in arm.path("tool")] == ["to_world", "turn", "bend", "wrist"]
    assert [joint.name for joint in arm.moving("left_finger")] == ["turn", "bend", "wrist"]
    assert list(arm.below("upper")) == ["upper", "tool", "left_finger", "right_finger"]
    assert arm.reach("tool") == pytest.approx(2 * math.hypot(0.03, 0.2))
    assert arm.without({"tool"}).tips() == ["upper", "left_finger", "right_finger", "other"]
