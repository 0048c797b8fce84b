"""Kinematics compared with Drake's floating plant and finite differences."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from scipy.spatial.transform import Rotation

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.robot import TOOL_FRAME, RobotDescription, add_robot
from aerodrake.model.vehicle.state import VehicleState, split_state

SEEDS = range(10)


@pytest.fixture(scope="module")
def kinematics(vehicle) -> Kinematics:
    return Kinematics(vehicle.plant)


@pytest.fixture(scope="module")
def floating(scenario) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    add_robot(plant, RobotDescription.read(scenario.vehicle.robot))
    plant.Finalize()
    return plant


def state_at(xi: np.ndarray, velocity: np.ndarray) -> VehicleState:
    """Returns the state at xi = [p_B, roll, pitch, yaw, q] and velocity [omega_W, v_B, q']."""
    quaternion = Rotation.from_euler("xyz", xi[3:6]).as_quat(scalar_first=True)
    return split_state(np.concatenate([quaternion, xi[:3], xi[6:], velocity]))


def random_coordinates(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Returns random xi, with pitch away from gimbal lock, and a velocity."""
    rng = np.random.default_rng(seed)
    xi = rng.uniform(-2, 2, 12)
    xi[4] = rng.uniform(-1.2, 1.2)
    return xi, rng.normal(size=12)


@pytest.mark.parametrize("seed", SEEDS)
def test_position_and_velocity_match_the_floating_plant(kinematics, floating, seed):
    state = state_at(*random_coordinates(seed))
    at = kinematics.end_effector(state)
    context = floating.CreateDefaultContext()
    x = state.to_vector()
    floating.SetPositionsAndVelocities(context, x)
    tool, world = floating.GetFrameByName(TOOL_FRAME), floating.world_frame()
    p_E = floating.CalcPointsPositions(context, tool, np.zeros(3), world)[:, 0]
    J = floating.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, tool, np.zeros(3), world, world
    )
    roll_rate, pitch_rate, yaw_rate = state.rpy_rates
    velocity = at.J_c @ [*state.v_B, yaw_rate, *state.qdot] + at.J_u @ [roll_rate, pitch_rate]
    np.testing.assert_allclose(at.p_E, p_E, atol=1e-12)
    np.testing.assert_allclose(velocity, J @ x[floating.num_positions() :], atol=1e-12)


@pytest.mark.parametrize("seed", SEEDS)
def test_jacobians_are_derivatives_of_the_position(kinematics, seed):
    xi, velocity = random_coordinates(seed)
    h = 1e-6

    def difference(i: int, quantity: str) -> np.ndarray:
        step = h * np.eye(len(xi))[i]
        ends = [kinematics.end_effector(state_at(xi + s, velocity)) for s in (step, -step)]
        return (getattr(ends[0], quantity) - getattr(ends[1], quantity)) / (2 * h)

    at = kinematics.end_effector(state_at(xi, velocity))
    by_xi = np.column_stack([difference(i, "p_E") for i in range(len(xi))])
    np.testing.assert_allclose(at.J_c, by_xi[:, [0, 1, 2, 5, *range(6, 12)]], atol=1e-8)
    np.testing.assert_allclose(at.J_u, by_xi[:, [3, 4]], atol=1e-8)
    np.testing.assert_allclose(at.J_yaw, by_xi[:, 5], atol=1e-8)
    np.testing.assert_allclose(at.J_s, by_xi[:, [0, 1, 2, *range(6, 12)]], atol=1e-8)
    in_base = np.column_stack([difference(i, "p_EB") for i in range(6, 12)])
    np.testing.assert_allclose(at.J_B, in_base, atol=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_tools_axis_and_its_jacobians(kinematics, floating, seed):
    """Compared with -z of the frame `tool` in Drake's plant, and central differences."""
    xi, velocity = random_coordinates(seed)
    state = state_at(xi, velocity)
    context = floating.CreateDefaultContext()
    floating.SetPositionsAndVelocities(context, state.to_vector())
    R_WE = floating.GetFrameByName(TOOL_FRAME).CalcPoseInWorld(context).rotation().matrix()
    at, h = kinematics.tool_axis(state), 1e-6
    np.testing.assert_allclose(at.value, -R_WE[:, 2], atol=1e-12)
    by_xi = np.empty((3, len(xi)))
    for i, step in enumerate(h * np.eye(len(xi))):
        ends = [kinematics.tool_axis(state_at(xi + s, velocity)).value for s in (step, -step)]
        by_xi[:, i] = (ends[0] - ends[1]) / (2 * h)
    np.testing.assert_allclose(at.J_c, by_xi[:, [0, 1, 2, 5, *range(6, 12)]], atol=1e-8)
    np.testing.assert_allclose(at.J_u, by_xi[:, [3, 4]], atol=1e-8)
    np.testing.assert_array_equal(at.r, at.value)


def test_position_is_composed_of_base_and_arm(kinematics):
    state = state_at(*random_coordinates(0))
    at = kinematics.end_effector(state)
    np.testing.assert_allclose(at.r, state.R_B @ at.p_EB, atol=1e-12)
    np.testing.assert_allclose(at.p_E, state.p_B + at.r, atol=1e-12)
    p_EB, J_B = kinematics.arm(state.q)
    np.testing.assert_array_equal(at.p_EB, p_EB)
    np.testing.assert_array_equal(at.J_B, J_B)
    for quantity, by_jacobian in zip(
        kinematics.tool(state.q), (p_EB, kinematics.arm_axis(state.q)[0]), strict=True
    ):
        np.testing.assert_allclose(quantity, by_jacobian, atol=1e-15)
