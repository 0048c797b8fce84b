"""Parts of a sample, and its noise against a hand calculation and Drake's rotations."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw, RotationMatrix

from aerodrake.model.sensing.sample import Deviations, noise_size, noisy, sampled
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Sensors

JOINTS = 6
SIZE = VehicleState.size(JOINTS)
SIGMA = Deviations(position=0.1, velocity=0.2, attitude=0.3, rate=0.4, joint=0.5)

draws = arrays(float, noise_size(JOINTS), elements=st.floats(-4, 4))
states = arrays(float, SIZE, elements=st.floats(-3, 3)).filter(
    lambda x: np.linalg.norm(x[:4]) > 0.1
)


def test_deviations_are_the_scenarios():
    config = Sensors(
        position_noise_m=0.1,
        velocity_noise_m_s=0.2,
        attitude_noise_rad=0.15,
        rate_noise_rad_s=0.4,
        joint_noise_rad=0.05,
    )
    assert Deviations.make(config) == SIGMA._replace(attitude=0.15, joint=0.05)


def test_a_sample_has_the_arm_of_one_state_and_the_base_of_another():
    arm, base = np.arange(SIZE) + 0.5, -np.arange(float(SIZE))
    sample = split_state(sampled(arm, base))
    for key in ("quaternion", "p_B", "omega_W", "v_B"):
        expected = getattr(split_state(base), key)
        np.testing.assert_array_equal(getattr(sample, key), expected)
    for key in ("q", "qdot"):
        expected = getattr(split_state(arm), key)
        np.testing.assert_array_equal(getattr(sample, key), expected)


@given(states, draws)
def test_each_part_has_its_own_draws(x, noise):
    original = x.copy()
    sample, true = (split_state(y) for y in (noisy(SIGMA, x, noise), x))
    np.testing.assert_array_equal(x, original)
    np.testing.assert_allclose(sample.p_B, true.p_B + 0.1 * noise[:3])
    np.testing.assert_allclose(sample.v_B, true.v_B + 0.2 * noise[3:6])
    np.testing.assert_allclose(sample.omega_W, true.omega_W + 0.4 * noise[9:12])
    np.testing.assert_allclose(sample.q, true.q + 0.5 * noise[12:])
    np.testing.assert_array_equal(sample.qdot, true.qdot)


@given(states, draws)
def test_attitude_is_turned_by_roll_pitch_and_yaw_in_its_own_frame(x, noise):
    """As in Drake, also the quaternion: of length 1 and w at least 0."""
    quaternion = noisy(SIGMA, x, noise)[:4]
    true = RotationMatrix(Quaternion(x[:4] / np.linalg.norm(x[:4])))
    turned = true.multiply(RollPitchYaw(0.3 * noise[6:9]).ToRotationMatrix())
    np.testing.assert_allclose(
        RotationMatrix(Quaternion(quaternion)).matrix(), turned.matrix(), atol=1e-13
    )
    assert quaternion[0] >= 0
    np.testing.assert_allclose(np.linalg.norm(quaternion), 1, atol=1e-14)
