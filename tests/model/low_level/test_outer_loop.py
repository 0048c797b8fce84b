"""Limits of the outer loop; tests/systems/test_flight_controller.py tests its law."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.low_level.flight_state import FlightState
from aerodrake.model.low_level.outer_loop import OuterLoop, outer_loop
from aerodrake.model.vehicle.vehicle import GRAVITY

setpoints = st.lists(st.floats(-3, 3), min_size=9, max_size=9).map(np.array)


@pytest.fixture(scope="module")
def outer(scenario, vehicle) -> OuterLoop:
    return OuterLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, 0.01)


@pytest.fixture(scope="module")
def last(vehicle) -> FlightState:
    thrust = np.full(4, vehicle.mass * GRAVITY / 4)
    return FlightState.at_rest(vehicle.p_B, np.zeros(3), thrust, vehicle.mass, vehicle.joints)


@given(setpoint=setpoints)
def test_acceleration_is_limited_by_tilt_and_thrust(scenario, vehicle, outer, last, setpoint):
    """As desired if possible; else at the limits, with the same signs on the horizontal axes."""
    state = vehicle.trim_state
    command = outer_loop(outer, last, state, setpoint)
    u_v, a_B = command.u_v, command.a_B
    desired, limited = (a + [0, 0, GRAVITY] for a in (u_v, a_B))
    max_thrust = 4 * scenario.vehicle.rotor.max_thrust_n / vehicle.mass
    max_slope = np.tan(scenario.flight.max_tilt_rad)

    def is_within(thrust: np.ndarray, margin: float) -> bool:
        is_upright = np.hypot(*thrust[:2]) <= thrust[2] * max_slope + margin
        return is_upright and np.linalg.norm(thrust) <= max_thrust + margin

    assert is_within(limited, 1e-9)
    if is_within(desired, -1e-9) and desired[2] > 0.2 * GRAVITY:
        np.testing.assert_allclose(a_B, u_v, atol=1e-12)
    assert np.all(limited[:2] * desired[:2] >= 0)
