"""What the inner loop believes and remembers; it is flown in tests/systems."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from aerodrake.model.low_level.flight_memory import initial_memory, memory_parts
from aerodrake.model.low_level.inner_loop import InnerLoop, inner_loop
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import GRAVITY
from aerodrake.model.vehicle.whole_body import rigid_body_effort

PERIOD = 0.01


@pytest.fixture(scope="module")
def inner(scenario, vehicle) -> InnerLoop:
    return InnerLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, PERIOD)


@pytest.fixture(scope="module")
def memory(vehicle) -> np.ndarray:
    return initial_memory(vehicle.p_B, np.zeros(3), np.full(4, vehicle.mass * GRAVITY / 4))


@pytest.mark.parametrize("seed", range(3))
def test_the_believed_acceleration_solves_the_equations_of_the_rotors_lag(
    scenario, vehicle, inner, memory, seed
):
    """Angular: of mean torque, the gyroscopic one off. Linear: along an axis that turns."""
    rng = np.random.default_rng(seed)
    state = split_state(vehicle.trim_state.copy())
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
