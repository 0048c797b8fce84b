"""Poses as in a URDF."""

import math

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from aerodrake.mounting.pose import Pose

POSE = Pose((0.1, -0.2, 0.3), (0.4, -0.5, 2.6))


def test_a_pose_is_a_transform():
    X = POSE.transform()
    assert X.IsExactlyEqualTo(RigidTransform(RollPitchYaw(0.4, -0.5, 2.6), [0.1, -0.2, 0.3]))
    assert np.concatenate(Pose.of(X)) == pytest.approx(np.concatenate(POSE))


@pytest.mark.parametrize("pitch", [math.pi / 2, -math.pi / 2])
def test_a_pose_at_the_singularity_of_its_angles(pitch):
    X = RigidTransform(RollPitchYaw(0.3, pitch, -0.8), [0, 0, 1])
    assert Pose.of(X).transform().IsNearlyEqualTo(X, 1e-12)
