"""Typed trees of arms."""

import math

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from aerodrake.mounting.arm import ArmJoint, Pose
from tests.arm_urdfs import ARM, plant, pose, read

POSE = Pose((0.1, -0.2, 0.3), (0.4, -0.5, 2.6))


def test_a_pose_is_a_transform():
    X = POSE.transform()
    assert X.IsExactlyEqualTo(RigidTransform(RollPitchYaw(0.4, -0.5, 2.6), [0.1, -0.2, 0.3]))
    assert np.concatenate(Pose.of(X)) == pytest.approx(np.concatenate(POSE))


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_a_pose_at_the_singularity_of_its_angles(pitch):
    X = RigidTransform(RollPitchYaw(0.3, pitch, -0.8), [0, 0, 1])
    assert Pose.of(X).transform().IsNearlyEqualTo(X, 1e-12)


def test_a_joint_at_a_position():
    turned = ArmJoint("j", "revolute", "a", "b", axis=(0, 0, -2)).at(0.5)
    assert turned.kind == "fixed" and turned.origin.rpy == pytest.approx((0, 0, -0.5))
    moved = ArmJoint("j", "prismatic", "a", "b", POSE, axis=(0, 3, 4)).at(0.5)
    expected = POSE.transform() @ np.array([0, 0.3, 0.4])
    assert moved.origin.xyz == pytest.approx(expected)
    assert ArmJoint("j", "prismatic", "a", "b", POSE).at(0).origin is POSE


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
