"""Equivalent models compared with the differential equations they discretise."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from aerodrake.model.equivalent.axis_models import AXIS_MODELS, flight_axis
from aerodrake.model.equivalent.initial_state import Signals, Thrust
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Flight, Model, Rates, Scenario

K_B = np.array([6.67, 1.8, 2.38])
JOINTS = 6


def base_slope(kind: str, k: np.ndarray, p, p_d, v_d, delta):
    """Returns p_B' by the differential equation of each kind."""
    if kind == "integral":
        return v_d
    return k * (p_d - p) + delta + (v_d if kind == "velocity_aware" else 0)


@pytest.mark.parametrize("kind", ["exact", "velocity_aware", "integral"])
@pytest.mark.parametrize("dt", [0.005, 0.02, 0.2])
def test_solves_its_equation_under_constant_input(kind, dt):
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
    # The wrong measured velocity must not propagate.
    signals = Signals(y[:3], np.full(3, 7.0), setpoint, np.concatenate([y[9:], qddot]))
    x = model.initial_state(signals)
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
    """Measured base and commanded arm; the integral model takes both from their setpoints."""
    model = EquivalentModel.make(kind, K_B, 0.02, 2)
    base_setpoint = np.array([1.0, 2, 3, 0.1, 0.2, 0.3, 9, 9, 9])
    joint_setpoint = np.array([4.0, 5, 0.4, 0.5, 9, 9])
    p_B, v_B = np.array([11.0, 12, 13]), np.array([0.11, 0.12, 0.13])
    x = model.initial_state(Signals(p_B, v_B, base_setpoint, joint_setpoint))
    expected = [11, 0.11, 1, 0.1, 12, 0.12, 2, 0.2, 13, 0.13, 3, 0.3, 4, 0.4, 5, 0.5]
    if kind == "integral":
        expected[0:2], expected[4:6], expected[8:10] = (1, 0.1), (2, 0.2), (3, 0.3)
    np.testing.assert_array_equal(x, expected)


@pytest.fixture(scope="module")
def flight() -> EquivalentModel:
    return EquivalentModel.of(Scenario(), JOINTS)


def test_kinds_by_k_b_have_the_rate_of_the_mpc():
    rates = Rates(mpc_period_s=0.04)
    for kind in AXIS_MODELS:
        scenario = Scenario(rates=rates, model=Model(kind=kind, k_b=tuple(K_B)))
        one, other = EquivalentModel.of(scenario, 4), EquivalentModel.make(kind, K_B, 0.04, 4)
        for name in ("A", "B", "C", "acceleration", "axis_states", "base_is_commanded", "dt"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        assert len(one.hidden) == 0


def test_layout_of_the_flight_model():
    scenario = Scenario(flight=Flight(rate_gain=(24.0, 22.0, 12.0)), rates=Rates(mpc_period_s=0.04))
    model = EquivalentModel.of(scenario, 4)
    names = ("p", "v", "p_d", "v_d", "b", "d", "h", "r", "alpha", "w")
    assert (model.axis_states, model.joints, model.dt) == (names, 4, 0.04)
    assert model.A.shape == (30 + 8, 30 + 8) and model.B.shape == (30 + 8, 7)
    np.testing.assert_array_equal(model.base_state("d"), [5, 15, 25])
    np.testing.assert_array_equal(model.hidden, [8, 18, 28, 9, 19, 29])
    np.testing.assert_array_equal(model.joint_position, [30, 32, 34, 36])
    for axis in range(3):
        one = flight_axis(axis, scenario.flight, scenario.vehicle.rotor, 0.01, 0.04)
        block = slice(10 * axis, 10 * axis + 10)
        np.testing.assert_array_equal(model.A[block, block], one.A)
        np.testing.assert_array_equal(model.B[block, axis], one.B)
        np.testing.assert_array_equal(model.C[block, axis], one.C)
        np.testing.assert_array_equal(model.acceleration[axis, block], one.acceleration)
    assert np.count_nonzero(model.acceleration) == 3


def test_joints_are_double_integrators_beside_the_flight_model(flight):
    x, u = np.zeros(len(flight.A)), np.zeros(3 + JOINTS)
    x[flight.joint_position], x[flight.joint_velocity], u[3:] = 0.3, -0.4, 2.0
    after = flight.predict(x, u, np.zeros(3))
    np.testing.assert_allclose(after[flight.joint_position], 0.3 - 0.4 * 0.02 + 0.0002 * 2)
    np.testing.assert_allclose(after[flight.joint_velocity], -0.4 + 0.02 * 2)
    np.testing.assert_array_equal(after[:30], 0)


def test_thrust_is_along_the_bases_axis_and_turns_with_it():
    """b from the attitude, r by finite differences as the base rotates."""
    state = split_state(np.zeros(13 + 2 * JOINTS))
    turned = Rotation.from_euler("zyx", [0.4, 0.2, -0.3])
    state.quaternion[:] = np.roll(turned.as_quat(), 1)
    state.omega_W[:] = 0.5, -0.7, 0.9
    thrust = Thrust.make(state, 10.5, np.full(3, 0.4), np.arange(6.0))

    def b(turned):
        return turned.apply([0, 0, 10.5]) - [0, 0, 9.81]

    h = 1e-6
    after, before = (Rotation.from_rotvec(s * h * state.omega_W) * turned for s in (1, -1))
    np.testing.assert_allclose(thrust.b, b(turned), atol=1e-12)
    slope = (b(after) - b(before)) / (2 * h)
    assert abs(slope[2]) > 1
    np.testing.assert_allclose(thrust.r, [*slope[:2], 0], atol=1e-7)
    np.testing.assert_array_equal(thrust.d, np.full(3, 0.4))
    np.testing.assert_array_equal(thrust.h, [0, 1, 2])


THRUST = Thrust(
    b=np.array([1.0, 2, 3]), r=np.array([4.0, 5, 0]), d=np.full(3, 0.4), h=np.arange(3.0)
)
BASE, ARM = np.arange(9.0), np.arange(3.0 * JOINTS)
SIGNALS = Signals(np.ones(3), np.full(3, 2.0), BASE, ARM, THRUST)


def test_first_state_of_the_flight_model_is_measured_except_hidden_states(flight):
    x = flight.initial_state(SIGNALS)
    for i in range(3):
        measured = [1, 2, BASE[i], BASE[3 + i], THRUST.b[i], 0.4, i, THRUST.r[i], 0, 0]
        np.testing.assert_array_equal(x[10 * i : 10 * i + 10], measured)
    np.testing.assert_array_equal(x[flight.joint_position], ARM[:JOINTS])
    np.testing.assert_array_equal(x[flight.joint_velocity], ARM[JOINTS : 2 * JOINTS])


def test_hidden_states_are_predicted_from_the_last_tick(flight):
    last = np.random.default_rng(0).normal(size=len(flight.A))
    x, fresh = flight.initial_state(SIGNALS, last), flight.initial_state(SIGNALS)
    u = np.concatenate([BASE[6:], ARM[2 * JOINTS :]])
    expected = flight.predict(last, u, np.zeros(3))
    np.testing.assert_allclose(x[flight.hidden], expected[flight.hidden], atol=1e-12)
    assert np.all(np.delete(x == fresh, flight.hidden)) and np.all(x[flight.hidden] != 0)


@pytest.mark.parametrize("kind", AXIS_MODELS)
def test_models_by_k_b_depend_on_neither_thrust_nor_the_last_tick(kind):
    model = EquivalentModel.make(kind, K_B, 0.02, JOINTS)
    alone, last = Signals(*SIGNALS[:4]), np.full(len(model.A), 9.0)
    np.testing.assert_array_equal(model.initial_state(SIGNALS, last), model.initial_state(alone))
