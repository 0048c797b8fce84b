"""Flight laws against closed forms, Drake's rotations, and simulated closed loops."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RollPitchYaw, RotationMatrix
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from aerodrake.model.low_level.flight_law import (
    FlightGains,
    attitude_error,
    attitude_law,
    desired_attitude,
    desired_thrust,
    position_law,
)
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.scenario import Flight

AXES = [[1, 0, 0], [0, 1, 0], [0, 0, -1], [0.6, 0, 0.8], [-0.48, 0.6, 0.64]]
numbers = st.floats(-50, 50)
accelerations = st.tuples(numbers, numbers, numbers).map(np.array)


def random_rotation(seed: int) -> RotationMatrix:
    return RotationMatrix(Rotation.random(rng=np.random.default_rng(seed)).as_matrix())


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("angle", [0.0, 1e-8, 1e-3, 0.5, 1.5, 3.0])
def test_attitude_error_is_the_sine_of_the_angle_about_drakes_axis(axis, angle):
    R_d = random_rotation(0)
    R = R_d @ RotationMatrix(AngleAxis(angle, axis))
    error = attitude_error(R.matrix(), R_d.matrix())
    np.testing.assert_allclose(error, np.sin(angle) * np.array(axis), atol=1e-15)


@given(st.tuples(numbers, numbers, st.floats(0.1, 50)).map(np.array), st.floats(-3.1, 3.1))
def test_desired_attitude(thrust, yaw):
    """A rotation with z along the thrust and the yaw angle of roll, pitch and yaw."""
    R = desired_attitude(thrust, yaw)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) > 0
    np.testing.assert_allclose(R[:, 2] * np.linalg.norm(thrust), thrust, atol=1e-9)
    assert RollPitchYaw(RotationMatrix(R)).yaw_angle() == pytest.approx(yaw, abs=1e-9)


@given(accelerations, st.floats(0.05, 1.2))
def test_desired_thrust(u_v, max_tilt):
    """Tilted within its limit, upward, and as desired where possible."""
    desired = u_v + np.array([0, 0, GRAVITY])
    thrust = desired_thrust(u_v.copy(), max_tilt)
    tilt = np.arctan2(np.hypot(*thrust[:2]), thrust[2])
    assert tilt <= max_tilt + 1e-12
    assert thrust[2] == pytest.approx(max(desired[2], 0.2 * GRAVITY))
    if desired[2] > 0.2 * GRAVITY and np.arctan2(np.hypot(*desired[:2]), desired[2]) < max_tilt:
        np.testing.assert_allclose(thrust, desired, atol=1e-12)
    # The horizontal direction is unchanged.
    assert np.cross([*thrust[:2], 0], [*desired[:2], 0])[2] == pytest.approx(0, abs=1e-9)
    assert thrust[:2] @ desired[:2] >= 0


def test_position_law_makes_the_error_linear():
    """Under p'' = u_v + h the error obeys e''' = -k_v e'' - k_p e' - k_i e for any p_d."""
    gains = FlightGains.make(
        Flight(
            position_gain=(9.0, 25.0, 4.0),
            velocity_gain=(5.0, 10.0, 4.0),
            integral_gain=(1.0, 2.0, 0.5),
        )
    )
    h = np.array([1.0, -2.0, 0.5])
    amplitude = np.array([0.3, -0.2, 0.1])

    def slope(t, y):
        p, v, integral = y.reshape(3, 3)
        p_d, v_d, a_d = amplitude * np.sin(t), amplitude * np.cos(t), -amplitude * np.sin(t)
        u_v = position_law(gains, p - p_d, v - v_d, a_d, h, integral)
        return np.concatenate([v, u_v + h, p - p_d])

    e_0, edot_0 = np.array([0.1, 0.2, -0.1]), np.array([0.5, -0.3, 0.2])
    start = np.concatenate([e_0, amplitude + edot_0, np.zeros(3)])
    end = solve_ivp(slope, (0, 2), start, rtol=1e-10, atol=1e-12).y[:, -1].reshape(3, 3)
    for i in range(3):
        k_p, k_v, k_i = (gain[i] for gain in gains[:3])
        error = expm(2 * np.array([[0, 1, 0], [-k_p, -k_v, -k_i], [1, 0, 0]])) @ [
            e_0[i],
            edot_0[i],
            0,
        ]
        assert end[0, i] - amplitude[i] * np.sin(2) == pytest.approx(error[0], abs=1e-7)
        assert end[1, i] - amplitude[i] * np.cos(2) == pytest.approx(error[1], abs=1e-7)


@pytest.mark.parametrize("seed", range(3))
def test_attitude_law_turns_the_base_upright(seed):
    """omega' = u_omega + h_omega brings any attitude within 120 degrees to the desired one."""
    gains, h = FlightGains.make(Flight()), np.array([3.0, -2.0, 1.0])
    R_d = random_rotation(seed).matrix()
    axis = np.random.default_rng(seed).normal(size=3)
    start = Rotation.from_matrix(R_d) * Rotation.from_rotvec(2.1 * axis / np.linalg.norm(axis))

    def slope(t, y):
        R, omega = y[:9].reshape(3, 3), y[9:]
        u = attitude_law(gains, attitude_error(R, R_d), omega, h)
        return np.concatenate([(R @ np.cross(np.eye(3), omega)).ravel(), u + h])

    y = np.concatenate([start.as_matrix().ravel(), np.zeros(3)])
    end = solve_ivp(slope, (0, 5), y, rtol=1e-8, atol=1e-10).y[:, -1]
    np.testing.assert_allclose(end[:9].reshape(3, 3), R_d, atol=1e-4)
    np.testing.assert_allclose(end[9:], 0, atol=1e-3)
