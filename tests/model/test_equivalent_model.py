"""The equivalent models against the differential equations they discretise."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aerodrake.model.axis_models import AXIS_MODELS
from aerodrake.model.equivalent_model import EquivalentModel

K_B = np.array([6.67, 1.8, 2.38])
JOINTS = 6


def base_slope(kind: str, k: np.ndarray, p, p_d, v_d, delta):
    """p_B' by the equation that each kind stands for."""
    if kind == "integral":
        return v_d
    return k * (p_d - p) + delta + (v_d if kind == "velocity_aware" else 0)


@pytest.mark.parametrize("kind", ["exact", "velocity_aware", "integral"])
@pytest.mark.parametrize("dt", [0.005, 0.02, 0.2])
def test_solves_its_equation_under_held_input(kind, dt):
    rng = np.random.default_rng(0)
    p, p_d, v_d, delta, a_d = rng.normal(size=(5, 3))
    q, qdot, qddot = rng.normal(size=(3, JOINTS))
    if kind == "integral":
        p = p_d

    def slope(t, y):
        p, p_d, v_d, _, qdot = np.split(y, [3, 6, 9, 9 + JOINTS])
        return np.concatenate([base_slope(kind, K_B, p, p_d, v_d, delta), v_d, a_d, qdot, qddot])

    y = np.concatenate([p, p_d, v_d, q, qdot])
    end = solve_ivp(slope, (0, dt), y, rtol=1e-11, atol=1e-12).y[:, -1]
    p, p_d, v_d, q, qdot = np.split(end, [3, 6, 9, 9 + JOINTS])

    model = EquivalentModel.make(kind, K_B, dt, JOINTS)
    setpoint = np.concatenate([y[3:6], y[6:9], a_d])
    # A wrong measured velocity shows that it does not propagate.
    x = model.initial_state(y[:3], np.full(3, 7.0), setpoint, np.concatenate([y[9:], qddot]))
    after = model.predict(x, np.concatenate([a_d, qddot]), delta)

    np.testing.assert_allclose(after[model.base_position], p, atol=1e-9)
    velocity = base_slope(kind, K_B, p, p_d, v_d, delta)
    np.testing.assert_allclose(after[model.base_velocity], velocity, atol=1e-9)
    np.testing.assert_allclose(after[model.setpoint_position], p_d, atol=1e-9)
    np.testing.assert_allclose(after[model.setpoint_velocity], v_d, atol=1e-9)
    np.testing.assert_allclose(after[model.joint_position], q, atol=1e-9)
    np.testing.assert_allclose(after[model.joint_velocity], qdot, atol=1e-9)


@pytest.mark.parametrize("kind", AXIS_MODELS)
@pytest.mark.parametrize("joints", [6, 4])
def test_layout_of_state_input_and_residual(kind, joints):
    """x = [p_Bx, p_Bx', p_Bx,d, p_Bx,d', p_By, ..., q_1, q_1', ...], u and Delta by axis."""
    model = EquivalentModel.make(kind, K_B, 0.02, joints)
    assert model.joints == joints
    assert model.A.shape == (12 + 2 * joints,) * 2
    assert model.B.shape == (12 + 2 * joints, 3 + joints)
    everything = [model.base_position, model.base_velocity, model.setpoint_position]
    everything += [model.setpoint_velocity, model.joint_position, model.joint_velocity]
    np.testing.assert_array_equal(model.base_position, [0, 4, 8])
    np.testing.assert_array_equal(model.joint_position, range(12, 12 + 2 * joints, 2))
    np.testing.assert_array_equal(np.sort(np.concatenate(everything)), range(12 + 2 * joints))
    for axis in range(3):
        one = AXIS_MODELS[kind](K_B[axis], 0.02)
        block = slice(4 * axis, 4 * axis + 4)
        np.testing.assert_array_equal(model.A[block, block], one.A)
        np.testing.assert_array_equal(model.B[block, axis], one.B)
        np.testing.assert_array_equal(model.C[block, axis], one.C)
        np.testing.assert_array_equal(model.acceleration[axis, block], one.acceleration)
    assert np.count_nonzero(model.C) == (0 if kind == "integral" else 6)
    assert np.count_nonzero(model.B[12:]) == 2 * joints


@pytest.mark.parametrize("kind", AXIS_MODELS)
def test_initial_state(kind):
    """Measured base and commanded arm; the integral model believes the command for both."""
    model = EquivalentModel.make(kind, K_B, 0.02, 2)
    base_setpoint = np.array([1.0, 2, 3, 0.1, 0.2, 0.3, 9, 9, 9])
    joint_setpoint = np.array([4.0, 5, 0.4, 0.5, 9, 9])
    x = model.initial_state(
        np.array([11.0, 12, 13]), np.array([0.11, 0.12, 0.13]), base_setpoint, joint_setpoint
    )
    expected = [11, 0.11, 1, 0.1, 12, 0.12, 2, 0.2, 13, 0.13, 3, 0.3, 4, 0.4, 5, 0.5]
    if kind == "integral":
        expected[0:2], expected[4:6], expected[8:10] = (1, 0.1), (2, 0.2), (3, 0.3)
    np.testing.assert_array_equal(x, expected)
