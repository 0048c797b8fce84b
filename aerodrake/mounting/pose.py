"""Pose of a frame, as a URDF gives it."""

from typing import NamedTuple, Self

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw


class Pose(NamedTuple):
    """Pose of a frame in another, as in an `<origin>`.

    Attributes:
        xyz: m, position.
        rpy: rad, roll, pitch and yaw.
    """

    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, X: RigidTransform) -> Self:
        """Returns a transform as a pose."""
        rpy = RollPitchYaw(X.rotation()).vector()
        return cls(tuple(X.translation().tolist()), tuple(rpy.tolist()))

    def transform(self) -> RigidTransform:
        """Returns the pose as a transform."""
        return RigidTransform(RollPitchYaw(*self.rpy), np.array(self.xyz))
