"""Places in a picture: the target, the directions, the angle of view, and depths."""

import numpy as np
import pytest

from aerodrake.gallery.camera import NEAREST_M, Camera

CAMERA = Camera(np.array([0.8, 1.5, 1.7]), np.array([-0.1, 0.1, 1.3]), 200, 120, 0.6)


def pixel(point: np.ndarray) -> np.ndarray:
    return CAMERA.project(point)[0]


def test_the_target_is_in_the_middle_and_up_is_up():
    assert pixel(CAMERA.target) == pytest.approx([100, 60])
    right = CAMERA.pose.rotation().matrix()[:, 0]
    x, y = pixel(CAMERA.target + 0.1 * right)
    assert x > 100 and y == pytest.approx(60)
    assert pixel(CAMERA.target + [0, 0, 0.1])[1] < 60
    # The upper edge is half of the angle of view above the middle.
    distance = np.linalg.norm(CAMERA.target - CAMERA.eye)
    up = -CAMERA.pose.rotation().matrix()[:, 1]
    assert pixel(CAMERA.target + distance * np.tan(0.3) * up)[1] == pytest.approx(0)


def test_depths_are_along_the_axis_also_of_points_that_are_not_in_the_picture():
    forward = CAMERA.pose.rotation().matrix()[:, 2]
    depths = np.array([[2.0, NEAREST_M], [0.0, -1.0]])
    places, found = CAMERA.project(CAMERA.eye + depths[..., None] * forward)
    np.testing.assert_allclose(found, depths, atol=1e-12)
    np.testing.assert_allclose(places, np.tile([100.0, 60.0], (2, 2, 1)), atol=1e-9)
