"""Modelled acceleration and integral of the inner loop; tests/systems flies it."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from aerodrake.model.low_level.flight_state import FlightState
from aerodrake.model.low_level.inner_loop import InnerLoop, inner_loop
from aerodrake.model.low_level.outer_loop import PositionCommand
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.model.vehicle.whole_body import rigid_body_effort

PERIOD = 0.01


@pytest.fixture(scope="module")
def inner(scenario, vehicle) -> InnerLoop:
    return InnerLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, PERIOD)


@pytest.fixture(scope="module")
def last(vehicle) -> FlightState:
    thrust = np.full(4, vehicle.mass * GRAVITY / 4)
    return FlightState.at_rest(vehicle.p_B, np.zeros(3), thrust, vehicle.mass, vehicle.joints)


def position_command(u_v: np.ndarray, a_B: np.ndarray, integral=(0.0, 0.0, 0.0)) -> PositionCommand:
    return PositionCommand(np.zeros((3, 3)), np.array(integral), u_v, a_B)


@pytest.mark.parametrize("seed", range(3))
def test_the_modelled_acceleration_solves_the_equations_of_the_rotors_lag(
    scenario, vehicle, inner, last, seed
):
    """Angular: of the mean torque less the gyroscopic one. Linear: along a turning axis."""
    rng = np.random.default_rng(seed)
    state = split_state(vehicle.trim_state.copy())
    state.omega_W[:] = 0.05 * rng.normal(size=3)
    u_v, a_B = 0.05 * rng.normal(size=(2, 3))
    x = state.to_vector()
    effort = rigid_body_effort(vehicle.mass, vehicle.inertia, x, a_B)
    now, outputs = inner_loop(inner, last, x, position_command(u_v, a_B), effort)
    command = outputs.thrust_command
    assert outputs.saturated is False
    np.testing.assert_allclose(outputs.reaction, 0, atol=1e-14)
    rotor = scenario.vehicle.rotor
    mixer = vehicle.rotors.mixer(rotor.torque_ratio_m)

    def slope(t, y):
        thrust = y[:4]
        tau = np.where(command > thrust, rotor.lag_up_s, rotor.lag_down_s)
        torque = (mixer @ thrust)[1:] - np.cross(state.omega_W, vehicle.inertia @ state.omega_W)
        lift = Rotation.from_rotvec(t * state.omega_W).as_matrix()[:, 2] * command.sum()
        mean_lag = (rotor.lag_up_s + rotor.lag_down_s) / 2
        return np.concatenate(
            [
                (command - thrust) / tau,
                lift / vehicle.mass - [0, 0, GRAVITY],
                np.linalg.solve(vehicle.inertia, torque),
                [(command.sum() / vehicle.mass - y[10]) / mean_lag],
            ]
        )

    end = solve_ivp(
        slope, (0, PERIOD), [*last.rotor_thrust, *np.zeros(6), GRAVITY], rtol=1e-10, atol=1e-12
    ).y[:, -1]
    assert now.specific_thrust == pytest.approx(end[10], abs=1e-9)
    np.testing.assert_allclose(now.rotor_thrust, end[:4], atol=1e-6)
    np.testing.assert_allclose(now.acceleration, end[4:10] / PERIOD, atol=1e-4)


def test_unequal_lags_do_not_change_the_mean_of_the_specific_thrust(vehicle, inner, last):
    """Rotors with an alternating command give more thrust than commanded, by their model."""
    position = position_command(np.zeros(3), np.zeros(3))
    weight = vehicle.mass * GRAVITY
    now, excess = last, []
    for k in range(200):
        effort = np.array([(-1) ** k * 0.2, 0, 0, 0, 0, weight])
        now, outputs = inner_loop(inner, now, vehicle.trim_state, position, effort)
        assert outputs.thrust_command.sum() == pytest.approx(weight)
        assert now.specific_thrust == pytest.approx(GRAVITY, abs=1e-9)
        excess.append(now.rotor_thrust.sum() - weight)
    assert min(excess[-2:]) > 0.02


@pytest.mark.parametrize(("climb", "expected"), [(0.5, False), (100.0, True)])
def test_the_integral_is_constant_while_anything_saturates(vehicle, inner, last, climb, expected):
    u_v = np.array([0.0, 0.0, climb])
    position = position_command(u_v, np.zeros(3), [1.0, 2.0, 3.0])
    effort = np.array([0, 0, 0, 0, 0, vehicle.mass * GRAVITY])
    now, outputs = inner_loop(inner, last, vehicle.trim_state, position, effort)
    assert outputs.saturated is expected
    expected_integral = np.zeros(3) if expected else [1.0, 2.0, 3.0]
    np.testing.assert_array_equal(now.position_integral, expected_integral)
