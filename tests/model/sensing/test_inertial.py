"""Accelerometer and random walks against closed forms."""

import numpy as np
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.inertial import specific_force, walked
from aerodrake.model.vehicle.state import VehicleState
from tests.estimates import rest

TILT = Rotation.from_euler("xyz", [0.3, -0.2, 0.5])


def moving(v_B: np.ndarray, attitude: Rotation = TILT) -> np.ndarray:
    state: VehicleState = rest(v_B=np.array(v_B, dtype=float))
    return state._replace(quaternion=attitude.as_quat(scalar_first=True)).to_vector()


def test_at_rest_it_measures_minus_gravity():
    force = specific_force(moving([0, 0, 0]), moving([0, 0, 0]), 0.01)
    np.testing.assert_allclose(force, TILT.inv().apply([0, 0, 9.81]), atol=1e-12)


def test_in_free_fall_it_measures_nothing():
    force = specific_force(moving([1, 0, 0]), moving([1, 0, -0.0981]), 0.01)
    np.testing.assert_allclose(force, 0, atol=1e-12)


def test_an_acceleration_in_the_base_frame_is_measured_in_it():
    a = np.array([1.0, -2.0, 0.5])
    force = specific_force(moving([0, 0, 0]), moving(TILT.apply(a) * 0.01), 0.01)
    np.testing.assert_allclose(force, a + TILT.inv().apply([0, 0, 9.81]), atol=1e-12)


def test_a_turn_within_the_period_is_averaged():
    """Against the integral of the specific force, at a constant rate; the error is of order 2."""
    omega, dt = np.array([0.0, 2.0, 0.0]), 0.01
    ends = [moving([0, 0, 0], TILT * Rotation.from_rotvec(t * omega)) for t in (0, dt)]
    times = dt * (np.arange(1000) + 0.5) / 1000
    exact = np.mean(
        [(TILT * Rotation.from_rotvec(t * omega)).inv().apply([0, 0, 9.81]) for t in times], axis=0
    )
    np.testing.assert_allclose(specific_force(*ends, dt), exact, atol=9.81 * (2 * dt) ** 2 / 12)


def test_the_variance_of_a_drift_grows_linearly():
    random, drift, dt = np.random.default_rng(0), 0.02, 0.005
    bias, variances = np.tile([0.1, 0.2, 0.3], (4000, 1)), []
    for k in range(1, 401):
        bias = walked(bias, drift, random.normal(size=bias.shape), dt)
        if k % 100 == 0:
            variances.append(bias.var(axis=0))
    np.testing.assert_allclose(bias.mean(axis=0), [0.1, 0.2, 0.3], atol=0.002)
    times = dt * np.arange(100, 401, 100)[:, np.newaxis]
    np.testing.assert_allclose(variances, drift**2 * times * np.ones(3), rtol=0.1)
