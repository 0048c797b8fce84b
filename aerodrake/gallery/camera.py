"""Pinhole camera of pictures of the vehicle."""

from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

NEAREST_M = 0.05
"""Smallest distance from the camera at which points have a place in the picture."""


@dataclass(frozen=True, eq=False)
class Camera:
    """A pinhole camera.

    Attributes:
        eye, target: (3,) m, its place and the point in the middle of the picture, in the world.
        width, height: Size of the picture in pixels.
        view_rad: Vertical angle of view.
    """

    eye: np.ndarray
    target: np.ndarray
    width: int
    height: int
    view_rad: float

    @property
    def pose(self) -> RigidTransform:
        """Pose in the world: x to the right, y down, z forward."""
        forward = (self.target - self.eye) / np.linalg.norm(self.target - self.eye)
        right = np.cross(forward, [0.0, 0.0, 1.0])
        right /= np.linalg.norm(right)
        axes = np.column_stack([right, np.cross(forward, right), forward])
        return RigidTransform(RotationMatrix(axes), self.eye)

    def project(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Returns the places (..., 2) in pixels, y down, of points (..., 3) of the world in m.

        The second result are their depths (...) in m, along the axis of the camera. Places are
        valid from a depth of `NEAREST_M` on.
        """
        local = (points - self.eye) @ self.pose.rotation().matrix()
        depth = local[..., 2]
        focal = self.height / 2 / np.tan(self.view_rad / 2)
        scale = focal / np.maximum(depth, NEAREST_M)
        return np.array([self.width, self.height]) / 2 + scale[..., None] * local[..., :2], depth
