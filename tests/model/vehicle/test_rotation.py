"""Compiled rotations compared with Drake's and SciPy's."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix
from scipy.spatial.transform import Rotation

from aerodrake.model.vehicle.rotation import (
    apply,
    conjugate,
    cross,
    product,
    quaternion_of,
    roll_pitch_yaw,
    rotation_matrix,
    rotation_vector,
    turn,
    turned,
    vee,
)

numbers = st.floats(-1, 1)
vectors = st.tuples(numbers, numbers, numbers).map(np.array)
quaternions = (
    st.tuples(numbers, numbers, numbers, numbers)
    .map(np.array)
    .filter(lambda q: np.linalg.norm(q) > 1e-3)
)


def drakes(quaternion):
    return RotationMatrix(Quaternion(quaternion / np.linalg.norm(quaternion)))


@given(quaternions)
def test_matrix_is_drakes(q):
    np.testing.assert_allclose(rotation_matrix(q), drakes(q).matrix(), atol=1e-14)


@given(quaternions)
def test_roll_pitch_yaw_is_drakes(q):
    R = drakes(q)
    if abs(np.cos(RollPitchYaw(R).pitch_angle())) > 1e-3:
        angles = roll_pitch_yaw(R.matrix())
        np.testing.assert_allclose(
            RollPitchYaw(angles).ToRotationMatrix().matrix(), R.matrix(), atol=1e-10
        )
        turns = (angles - RollPitchYaw(R).vector()) / (2 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)


@given(vectors, st.sampled_from([1e-9, 1.0, 7.0]))
def test_quaternion_of_roll_pitch_yaw_is_drakes(rpy, size):
    quaternion = quaternion_of(size * rpy)
    assert np.linalg.norm(quaternion) == pytest.approx(1, abs=1e-14)
    expected = RollPitchYaw(size * rpy).ToRotationMatrix().matrix()
    np.testing.assert_allclose(rotation_matrix(quaternion), expected, atol=1e-14)


@given(quaternions)
def test_conjugate_is_the_inverse(q):
    np.testing.assert_allclose(
        rotation_matrix(conjugate(q)), drakes(q).inverse().matrix(), atol=1e-14
    )


@given(quaternions, quaternions)
def test_product_is_drakes(a, b):
    np.testing.assert_allclose(
        rotation_matrix(product(a, b)), drakes(a).multiply(drakes(b)).matrix(), atol=1e-12
    )


@given(quaternions, vectors, st.sampled_from([0.0, 1e-14, 1e-9, 1e-3, 1.0, 3.0]))
def test_turned_is_scipys(q, v, length):
    v = v * length
    rotated = turned(q, v)
    assert np.linalg.norm(rotated) == pytest.approx(1, abs=1e-14)
    expected = drakes(q).matrix() @ Rotation.from_rotvec(v).as_matrix()
    np.testing.assert_allclose(rotation_matrix(rotated), expected, atol=1e-12)


@given(quaternions)
def test_rotation_vector_is_scipys(q):
    expected = Rotation.from_quat(q, scalar_first=True)
    vector = rotation_vector(q)
    np.testing.assert_allclose(
        Rotation.from_rotvec(vector).as_matrix(), expected.as_matrix(), atol=1e-9
    )
    assert np.linalg.norm(vector) <= np.pi + 1e-12


def test_small_rotation_vectors_keep_their_digits():
    v = np.array([3e-11, -2e-10, 1e-9])
    level = np.array([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(rotation_vector(turned(level, v)), v, rtol=1e-12)
    np.testing.assert_array_equal(rotation_vector(-level), np.zeros(3))


@given(quaternions)
def test_vee_is_drakes_axis_by_the_sine(q):
    turn_of = drakes(q).ToAngleAxis()
    expected = turn_of.axis() * np.sin(turn_of.angle())
    np.testing.assert_allclose(vee(drakes(q).matrix()), expected, atol=1e-12)


@given(vectors, st.sampled_from([0.0, 1e-14, 1e-9, 1e-3, 1.0, 1.5]))
def test_turn_is_scipys_rotation_vector(v, length):
    """Up to 1.5 sqrt(3) rad."""
    v = v * length
    np.testing.assert_allclose(turn(Rotation.from_rotvec(v).as_matrix()), v, atol=1e-14)


@given(vectors, vectors)
def test_cross_is_numpys(a, b):
    np.testing.assert_allclose(cross(a, b), np.cross(a, b), atol=1e-14)


@given(vectors, vectors, vectors, vectors)
def test_apply_is_numpys(a, b, c, v):
    R = np.array([a, b, c])
    np.testing.assert_allclose(apply(R, v), R @ v, atol=1e-14)
    np.testing.assert_allclose(apply(R.T, v), R.T @ v, atol=1e-14)
