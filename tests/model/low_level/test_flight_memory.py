"""What the flight controller's loops remember."""

import numpy as np

from aerodrake.model.low_level.flight_memory import initial_memory, memory_parts


def test_memory_at_rest():
    p_B, h_omega, trim = np.array([1.0, 2, 3]), np.array([0.1, 0.2, 0.3]), np.array([5.0, 6, 7, 8])
    position, attitude, integral, R_d, omega_d, thrust = memory_parts(
        initial_memory(p_B, h_omega, trim)
    )
    np.testing.assert_array_equal(position, [p_B, np.zeros(3), np.zeros(3)])
    np.testing.assert_array_equal(attitude, [np.zeros(3), h_omega])
    np.testing.assert_array_equal(integral, np.zeros(3))
    np.testing.assert_array_equal(R_d, np.eye(3))
    np.testing.assert_array_equal(omega_d, np.zeros(3))
    np.testing.assert_array_equal(thrust, trim)
