"""Conversion of states and forces to those of MuJoCo and back."""

import numpy as np

from aerodrake.model.mujoco.conversion import (
    state_of,
    write_forces,
    write_positions_and_velocities,
)
from aerodrake.model.vehicle.state import VehicleState


def test_a_base_turned_about_z():
    """A base that faces along y, and rolls about its own x axis, which is y in the world."""
    half = np.sqrt(0.5)
    x = VehicleState(
        quaternion=np.array([half, 0, 0, half]),
        p_B=np.array([1.0, 2, 3]),
        q=np.array([0.4, 0.5]),
        omega_W=np.array([0.0, 2, 7]),
        v_B=np.array([4.0, 5, 6]),
        qdot=np.array([0.6, 0.7]),
    ).to_vector()
    qpos, qvel = np.empty(9), np.empty(8)
    write_positions_and_velocities(x, qpos, qvel)
    np.testing.assert_array_equal(qpos, [1, 2, 3, half, 0, 0, half, 0.4, 0.5])
    np.testing.assert_allclose(qvel, [4, 5, 6, 2, 0, 7, 0.6, 0.7], atol=1e-15)
    np.testing.assert_allclose(state_of(qpos, qvel), x, rtol=1e-15, atol=1e-15)


def test_forces():
    ctrl, qfrc, wrench = np.zeros(3), np.zeros(8), np.zeros(6)
    thrust, torque = np.array([9.0, 10, 11]), np.array([0.1, 0.2])
    write_forces(thrust, torque, np.array([1.0, 2, 3, 4, 5, 6, 7, 8]), ctrl, qfrc, wrench)
    np.testing.assert_array_equal(ctrl, thrust)
    np.testing.assert_array_equal(qfrc, [4, 5, 6, 0, 0, 0, 7.1, 8.2])
    np.testing.assert_array_equal(wrench, [0, 0, 0, 1, 2, 3])
