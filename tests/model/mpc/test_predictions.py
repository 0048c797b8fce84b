"""Predicted quantities against rotations and the definitions of the paper."""

import numpy as np
from scipy.spatial.transform import Rotation

from aerodrake.model.mpc.predictions import QUANTITIES, RATES, quantity_size, tilt_matrix
from tests.explicit_mpc import UP, G


def test_tilt_matrix_is_the_rotation_of_the_thrust_axis():
    """A rotation that points the thrust along g + a moves the tool by T a."""
    r = np.array([0.1, 0.2, -0.3])
    for a in 0.01 * np.vstack([np.eye(3), [1, -2, 0.5]]):
        thrust = a + G * UP
        turned = Rotation.align_vectors(thrust[None], UP[None])[0]
        np.testing.assert_allclose(tilt_matrix(r) @ a, turned.apply(r) - r, atol=2e-6)


def test_sizes_of_the_quantities(vehicle):
    sizes = {name: quantity_size(name, vehicle.joints) for name in QUANTITIES}
    assert sizes.pop("input") == 9
    assert sizes.pop("joint_position") == sizes.pop("joint_velocity") == 6
    assert set(sizes.values()) == {3}
    assert set(RATES) | set(RATES.values()) <= set(QUANTITIES)
