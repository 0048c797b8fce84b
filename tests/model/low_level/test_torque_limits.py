"""Torques at their limits, of joints that share inertia."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.low_level.torque_limits import within_limits


@st.composite
def arms(draw):
    """Draws an inertia (n, n) with a condition number of up to 1e4, and torques (n,)."""
    n = draw(st.integers(1, 6))
    random = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    axes, _ = np.linalg.qr(random.normal(size=(n, n)))
    scale = 10.0 ** random.uniform(-4, 0, n)
    return axes * scale @ axes.T, random.uniform(-3, 3, n)


@given(arms())
def test_torques_are_within_their_limits(arm):
    inertia, desired = arm
    torque = within_limits(inertia, desired, np.ones(len(desired)))
    assert np.all(np.abs(torque) <= 1)
    if np.all(np.abs(desired) <= 1):
        np.testing.assert_array_equal(torque, desired)


@given(arms())
def test_joints_within_their_limits_accelerate_as_desired(arm):
    inertia, desired = arm
    torque = within_limits(inertia, desired, np.ones(len(desired)))
    lost = np.linalg.solve(inertia, torque - desired)
    free = np.abs(torque) < 1
    scale = np.abs(np.linalg.inv(inertia)).max() * (1 + np.abs(torque - desired).max())
    np.testing.assert_allclose(lost[free] / scale, 0, atol=1e-9)


@given(st.floats(-5, 5), st.floats(-5, 5))
def test_two_joints_by_hand(first, second):
    """The second joint follows the first with the inertia that they share."""
    inertia = np.array([[2.0, 0.5], [0.5, 1.0]])
    torque = within_limits(inertia, np.array([first, second]), np.array([1.0, 1e3]))
    clipped = np.clip(first, -1, 1)
    np.testing.assert_allclose(torque, [clipped, second + 0.5 / 2.0 * (clipped - first)])


def test_independent_joints_are_clipped():
    torque = within_limits(np.diag([1.0, 2.0]), np.array([3.0, -3.0]), np.array([1.0, 2.0]))
    np.testing.assert_array_equal(torque, [1.0, -2.0])


def test_a_torque_that_only_serves_a_joint_at_its_limit_is_not_given():
    """Both exceed their limits, but the second only to accelerate with the first."""
    inertia = np.array([[2.0, 0.5], [0.5, 1.0]])
    torque = within_limits(inertia, inertia @ [300.0, 0.0], np.array([1.0, 5.0]))
    np.testing.assert_allclose(torque, [1.0, 0.25])
