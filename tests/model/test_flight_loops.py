"""What the loops remember and exchange; the loops themselves are flown in tests/systems."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from aerodrake.model.flight_loops import (
    InnerLoop,
    OuterLoop,
    commanded_motion,
    initial_memory,
    inner_loop,
    memory_parts,
    outer_loop,
    rigid_body_effort,
)
from aerodrake.model.vehicle import GRAVITY
from aerodrake.model.vehicle_state import VehicleState

PERIOD = 0.01
setpoints = st.lists(st.floats(-3, 3), min_size=9, max_size=9).map(np.array)


@pytest.fixture(scope="module")
def outer(scenario, vehicle) -> OuterLoop:
    return OuterLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, PERIOD)


@pytest.fixture(scope="module")
def inner(scenario, vehicle) -> InnerLoop:
    return InnerLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, PERIOD)


@pytest.fixture(scope="module")
def memory(vehicle) -> np.ndarray:
    thrust = np.full(4, vehicle.mass * GRAVITY / 4)
    return initial_memory(vehicle.p_B, np.array([0.1, 0.2, 0.3]), thrust)


def random_state(vehicle, seed: int) -> VehicleState:
    rng = np.random.default_rng(seed)
    state = VehicleState.from_vector(rng.normal(size=VehicleState.size(vehicle.joints)))
    state.quaternion[:] = np.roll(Rotation.random(rng=rng).as_quat(), 1)
    return state


def test_memory_at_rest(vehicle, memory):
    position, attitude, integral, R_d, omega_d, thrust = memory_parts(memory)
    np.testing.assert_array_equal(position, [vehicle.p_B, np.zeros(3), np.zeros(3)])
    np.testing.assert_array_equal(attitude, [np.zeros(3), [0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(R_d, np.eye(3))
    assert not integral.any() and not omega_d.any()
    assert thrust.sum() == pytest.approx(vehicle.mass * GRAVITY)


@given(setpoint=setpoints)
def test_what_tilt_and_thrust_allow_of_the_acceleration(scenario, vehicle, outer, memory, setpoint):
    """All of it where they allow it; else within them, with a share of each of its axes."""
    state = vehicle.trim_state
    _, u_v, a_B = outer_loop(outer, memory, np.zeros(6), state, setpoint)
    wanted, allowed = (a + [0, 0, GRAVITY] for a in (u_v, a_B))
    most = 4 * scenario.vehicle.rotor.max_thrust_n / vehicle.mass
    steepest = np.tan(scenario.flight.max_tilt_rad)

    def is_within(thrust: np.ndarray, by: float) -> bool:
        is_upright = np.hypot(*thrust[:2]) <= thrust[2] * steepest + by
        return is_upright and np.linalg.norm(thrust) <= most + by

    assert is_within(allowed, 1e-9)
    if is_within(wanted, -1e-9) and wanted[2] > 0.2 * GRAVITY:
        np.testing.assert_allclose(a_B, u_v, atol=1e-12)
    assert np.all(allowed[:2] * wanted[:2] >= 0)


@pytest.mark.parametrize("seed", range(3))
def test_commanded_motion_has_the_base_as_measured_and_the_arm_as_commanded(vehicle, seed):
    state, n = random_state(vehicle, seed), vehicle.joints
    q_d, qdot_d, qddot_d = np.random.default_rng(seed).normal(size=(3, n))
    x, vdot = commanded_motion(
        state.to_vector(), np.concatenate([q_d, qdot_d, qddot_d]), np.array([1.0, 2.0, 3.0])
    )
    found = VehicleState.from_vector(x)
    for part in ("quaternion", "p_B", "omega_W", "v_B"):
        np.testing.assert_array_equal(getattr(found, part), getattr(state, part))
    np.testing.assert_array_equal(found.q, q_d)
    np.testing.assert_array_equal(found.qdot, qdot_d)
    np.testing.assert_array_equal(vdot, [0, 0, 0, 1, 2, 3, *qddot_d])


@pytest.mark.parametrize("seed", range(3))
def test_rigid_body_effort_is_the_change_of_momentum_and_weight(vehicle, seed):
    """Angular momentum R J omega of a body that turns at a constant rate, by differences."""
    state, a_B = random_state(vehicle, seed), np.array([1.0, -2.0, 3.0])
    effort = rigid_body_effort(vehicle.mass, vehicle.inertia, state.to_vector(), a_B)
    np.testing.assert_allclose(effort[3:], vehicle.mass * (a_B + [0, 0, GRAVITY]), rtol=1e-12)

    def angular_momentum(t: float) -> np.ndarray:
        R = Rotation.from_rotvec(t * state.omega_W).as_matrix() @ state.R_B
        return R @ vehicle.inertia @ R.T @ state.omega_W

    h = 1e-5
    rate = (angular_momentum(h) - angular_momentum(-h)) / (2 * h)
    np.testing.assert_allclose(effort[:3], rate, atol=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_the_believed_acceleration_solves_the_equations_of_the_rotors_lag(
    scenario, vehicle, inner, memory, seed
):
    """Angular: of mean torque, the gyroscopic one off. Linear: along an axis that turns."""
    rng = np.random.default_rng(seed)
    state = VehicleState.from_vector(vehicle.trim_state.copy())
    state.omega_W[:] = 0.05 * rng.normal(size=3)
    u_v, a_B = 0.05 * rng.normal(size=(2, 3))
    x, position = state.to_vector(), np.zeros(12)
    effort = rigid_body_effort(vehicle.mass, vehicle.inertia, x, a_B)
    _, command, believed, reaction, specific, _, saturated = inner_loop(
        inner, memory, np.zeros(6), x, position, u_v, a_B, effort
    )
    assert saturated == 0
    np.testing.assert_allclose(reaction, 0, atol=1e-14)
    rotor = scenario.vehicle.rotor
    start = memory_parts(memory)[-1]
    mixer = vehicle.rotors.mixer(rotor.torque_ratio_m)

    def slope(t, y):
        thrust = y[:4]
        tau = np.where(command > thrust, rotor.lag_up_s, rotor.lag_down_s)
        torque = (mixer @ thrust)[1:] - np.cross(state.omega_W, vehicle.inertia @ state.omega_W)
        lift = Rotation.from_rotvec(t * state.omega_W).as_matrix()[:, 2] * command.sum()
        return np.concatenate(
            [
                (command - thrust) / tau,
                lift / vehicle.mass - [0, 0, GRAVITY],
                np.linalg.solve(vehicle.inertia, torque),
            ]
        )

    end = solve_ivp(slope, (0, PERIOD), [*start, *np.zeros(6)], rtol=1e-10, atol=1e-12).y[:, -1]
    assert specific[0] == pytest.approx(end[:4].sum() / vehicle.mass, abs=1e-7)
    np.testing.assert_allclose(believed, end[4:] / PERIOD, atol=1e-4)


@pytest.mark.parametrize(("climb", "expected"), [(0.5, False), (100.0, True)])
def test_the_integral_waits_while_anything_saturates(vehicle, inner, memory, climb, expected):
    u_v = np.array([0.0, 0.0, climb])
    position = np.concatenate([np.zeros(9), [1.0, 2.0, 3.0]])
    effort = np.array([0, 0, 0, 0, 0, vehicle.mass * GRAVITY])
    found = inner_loop(
        inner, memory, np.zeros(6), vehicle.trim_state, position, u_v, np.zeros(3), effort
    )
    assert found[-1] == expected
    integral = memory_parts(found[0])[2]
    np.testing.assert_array_equal(integral, np.zeros(3) if expected else [1.0, 2.0, 3.0])
