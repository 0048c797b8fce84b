"""The outer loop's limits; its law is flown in tests/systems/test_flight_controller.py."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aerodrake.model.low_level.flight_memory import initial_memory
from aerodrake.model.low_level.outer_loop import OuterLoop, outer_loop
from aerodrake.model.vehicle.vehicle import GRAVITY

setpoints = st.lists(st.floats(-3, 3), min_size=9, max_size=9).map(np.array)


@pytest.fixture(scope="module")
def outer(scenario, vehicle) -> OuterLoop:
    return OuterLoop.make(scenario.flight, scenario.vehicle.rotor, vehicle, 0.01)


@pytest.fixture(scope="module")
def memory(vehicle) -> np.ndarray:
    return initial_memory(vehicle.p_B, np.zeros(3), np.full(4, vehicle.mass * GRAVITY / 4))


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
