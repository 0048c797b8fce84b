"""Joints of arms."""

import numpy as np
import pytest

from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.pose import Pose

POSE = Pose((0.1, -0.2, 0.3), (0.4, -0.5, 2.6))


def test_a_joint_at_a_position():
    turned = ArmJoint("j", "revolute", "a", "b", axis=(0, 0, -2)).at(0.5)
    assert turned.kind == "fixed" and turned.origin.rpy == pytest.approx((0, 0, -0.5))
    moved = ArmJoint("j", "prismatic", "a", "b", POSE, axis=(0, 3, 4)).at(0.5)
    expected = POSE.transform() @ np.array([0, 0.3, 0.4])
    assert moved.origin.xyz == pytest.approx(expected)
    assert ArmJoint("j", "prismatic", "a", "b", POSE).at(0).origin is POSE
