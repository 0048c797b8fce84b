"""Parts of the state compared with Drake's plant, SciPy's rotations and finite differences."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from scipy.spatial.transform import Rotation

from aerodrake.model.vehicle.robot import BASE_FRAME, RobotDescription, add_robot
from aerodrake.model.vehicle.state import VehicleState, split_state


def random_state(seed: int, joints: int = 6) -> VehicleState:
    rng = np.random.default_rng(seed)
    rpy = rng.uniform([-3, -1.2, -3], [3, 1.2, 3])
    quaternion = Rotation.from_euler("xyz", rpy).as_quat(scalar_first=True)
    rest = rng.normal(size=VehicleState.size(joints) - 4)
    return split_state(np.concatenate([quaternion, rest]))


@pytest.mark.parametrize("joints", [1, 6, 7])
def test_vector_round_trip(joints):
    x = np.arange(float(VehicleState.size(joints)))
    state = split_state(x)
    assert len(state.q) == len(state.qdot) == joints
    np.testing.assert_array_equal(state.to_vector(), x)


def test_parts_over_time_are_those_of_each_instant():
    states = np.column_stack([random_state(seed).to_vector() for seed in range(4)])
    for name, part in split_state(states)._asdict().items():
        for i, x in enumerate(states.T):
            np.testing.assert_array_equal(part[:, i], getattr(split_state(x.copy()), name))


@pytest.mark.parametrize("joints", [0, 1, 6])
def test_a_state_at_rest_has_the_named_parts_and_no_motion(joints):
    q, rpy = np.linspace(-1, 1, joints), [0.1, -0.2, 2.0]
    x = VehicleState.at_rest([1.0, 2.0, 3.0], q, rpy).to_vector()
    state = split_state(x)
    assert len(x) == VehicleState.size(joints)
    np.testing.assert_array_equal(state.p_B, [1, 2, 3])
    np.testing.assert_array_equal(state.q, q)
    np.testing.assert_allclose(state.rpy, rpy, atol=1e-12)
    assert not np.any([*state.omega_W, *state.v_B, *state.qdot])


def test_parts_match_the_state_of_the_plant(scenario):
    plant = MultibodyPlant(0.0)
    add_robot(plant, RobotDescription.read(scenario.vehicle.robot))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    base = plant.GetBodyByName(BASE_FRAME)
    for seed in range(5):
        state = random_state(seed)
        plant.SetPositionsAndVelocities(context, state.to_vector())
        pose = plant.EvalBodyPoseInWorld(context, base)
        velocity = plant.EvalBodySpatialVelocityInWorld(context, base)
        np.testing.assert_allclose(state.R_B, pose.rotation().matrix(), atol=1e-12)
        np.testing.assert_allclose(state.p_B, pose.translation(), atol=1e-12)
        np.testing.assert_allclose(state.v_B, velocity.translational(), atol=1e-12)
        np.testing.assert_allclose(state.omega_W, velocity.rotational(), atol=1e-12)
        joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
        arm = [j for j in joints if j.num_positions() == 1]
        np.testing.assert_array_equal(state.q, [j.get_angle(context) for j in arm])
        np.testing.assert_array_equal(state.qdot, [j.get_angular_rate(context) for j in arm])


@pytest.mark.parametrize("seed", range(5))
def test_rpy_and_its_rates(seed):
    state, h = random_state(seed), 1e-6

    def rpy_at(t: float) -> np.ndarray:
        turned = Rotation.from_rotvec(state.omega_W * t) * Rotation.from_matrix(state.R_B)
        return turned.as_euler("xyz")

    np.testing.assert_allclose(state.rpy, rpy_at(0), atol=1e-12)
    np.testing.assert_allclose(state.rpy_rates, (rpy_at(h) - rpy_at(-h)) / (2 * h), atol=1e-7)


def test_quaternion_that_drifted_from_unit_norm():
    x = random_state(0).to_vector()
    drifted = x.copy()
    drifted[:4] *= 1.001
    state, other = split_state(x), split_state(drifted)
    np.testing.assert_allclose(other.R_B, state.R_B, atol=1e-14)
    np.testing.assert_allclose(other.rpy, state.rpy, atol=1e-14)
    np.testing.assert_allclose(other.rpy_rates, state.rpy_rates, atol=1e-14)
