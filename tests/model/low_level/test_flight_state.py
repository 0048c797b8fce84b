"""Initial state of the flight controller."""

import numpy as np

from aerodrake.model.low_level.flight_state import FlightState


def test_state_at_rest():
    p_B, h_omega, trim = np.array([1.0, 2, 3]), np.array([0.1, 0.2, 0.3]), np.array([5.0, 6, 7, 8])
    state = FlightState.at_rest(p_B, h_omega, trim, 13.0, 3)
    np.testing.assert_array_equal(state.position_observer, [p_B, np.zeros(3), np.zeros(3)])
    np.testing.assert_array_equal(state.attitude_observer, [np.zeros(3), h_omega])
    np.testing.assert_array_equal(state.position_integral, np.zeros(3))
    np.testing.assert_array_equal(state.R_d, np.eye(3))
    np.testing.assert_array_equal(state.omega_d, np.zeros(3))
    np.testing.assert_array_equal(state.rotor_thrust, trim)
    assert state.specific_thrust == 2.0
    np.testing.assert_array_equal(state.acceleration, [0, 0, 0, *-h_omega])
