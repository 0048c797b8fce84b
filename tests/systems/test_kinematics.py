"""Kinematics system: ports compared with Drake's floating plant, and caching."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.robot import BASE_FRAME, TOOL_FRAME, add_robot
from aerodrake.model.vehicle.state import split_state
from aerodrake.systems.kinematics import KinematicsSystem


class Counting(Kinematics):
    """Kinematics that count their evaluations."""

    asked = 0

    def end_effector(self, state):
        self.asked += 1
        return super().end_effector(state)


@pytest.fixture(scope="module")
def kinematics(vehicle) -> Counting:
    return Counting(vehicle.plant)


@pytest.fixture
def system(kinematics, vehicle) -> KinematicsSystem:
    kinematics.asked = 0
    return KinematicsSystem(kinematics, vehicle.joints, vehicle.p_O)


@pytest.fixture(scope="module")
def plant(vehicle) -> MultibodyPlant:
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    return plant


def states(vehicle, count: int = 5) -> np.ndarray:
    rng = np.random.default_rng(0)
    x = vehicle.trim_state + 0.3 * rng.normal(size=(count, len(vehicle.trim_state)))
    x[:, :4] /= np.linalg.norm(x[:, :4], axis=1, keepdims=True)
    return x


def evaluate(system, context, port):
    return system.GetOutputPort(port).Eval(context)


def fixed(system, x, reference):
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, x)
    system.GetInputPort("reference").FixValue(context, reference)
    return context


def test_trim_is_on_target_in_the_middle_of_the_learning_space(system, vehicle):
    context = fixed(system, vehicle.trim_state, [0.0, 0.2, 1.2, 9, 9, 9])
    p_E = evaluate(system, context, "end_effector").p_E
    np.testing.assert_allclose(p_E, [0, 0.2, 1.2], atol=1e-6)
    np.testing.assert_allclose(evaluate(system, context, "distances"), 0, atol=1e-6)


def test_distances_are_those_of_the_floating_plant(system, plant, vehicle):
    p_Ed = np.array([0.3, -0.4, 1.1])
    plant_context = plant.CreateDefaultContext()
    tool, base = plant.GetFrameByName(TOOL_FRAME), plant.GetFrameByName(BASE_FRAME)
    for x in states(vehicle):
        plant.SetPositionsAndVelocities(plant_context, x)
        p_E = tool.CalcPoseInWorld(plant_context).translation()
        p_EB = tool.CalcPose(plant_context, base).translation()
        context = fixed(system, x, [*p_Ed, 9, 9, 9])
        end_effector = evaluate(system, context, "end_effector")
        np.testing.assert_allclose(end_effector.p_E, p_E, atol=1e-12)
        np.testing.assert_allclose(
            evaluate(system, context, "distances"),
            [np.linalg.norm(p_E - p_Ed), np.linalg.norm(p_EB - vehicle.p_O)],
            atol=1e-12,
        )


def test_end_effector_moves_as_the_floating_plant_does(system, plant, vehicle):
    plant_context = plant.CreateDefaultContext()
    tool = plant.GetFrameByName(TOOL_FRAME)
    for x in states(vehicle):
        plant.SetPositionsAndVelocities(plant_context, x)
        v_E = tool.CalcSpatialVelocityInWorld(plant_context).translational()
        end_effector = evaluate(system, fixed(system, x, np.zeros(6)), "end_effector")
        state = split_state(x)
        rates = np.concatenate([state.v_B, state.rpy_rates[2:], state.qdot])
        moved = end_effector.J_c @ rates + end_effector.J_u @ state.rpy_rates[:2]
        np.testing.assert_allclose(moved, v_E, atol=1e-12)


def test_it_is_computed_once_for_all_consumers_and_never_stale(system, kinematics, vehicle):
    first, second = states(vehicle, 2)
    context = fixed(system, first, np.zeros(6))
    ports = ("end_effector", "distances")
    for _ in range(3):
        before = [evaluate(system, context, port) for port in ports]
    assert kinematics.asked == 1

    system.GetInputPort("reference").FixValue(context, np.ones(6))
    after = [evaluate(system, context, port) for port in ports]
    assert kinematics.asked == 1
    assert after[1][0] != before[1][0] and after[1][1] == before[1][1]

    system.GetInputPort("state").FixValue(context, second)
    context.SetTime(1.0)
    after = [evaluate(system, context, port) for port in ports]
    assert kinematics.asked == 2
    assert np.all(after[0].p_E != before[0].p_E) and np.all(after[1] != before[1])


def test_feedthrough_and_no_state(system):
    def through(source, port):
        return system.HasDirectFeedthrough(
            system.GetInputPort(source).get_index(), system.GetOutputPort(port).get_index()
        )

    assert all(through("state", port) for port in ("end_effector", "distances"))
    assert through("reference", "distances")
    assert not through("reference", "end_effector")
    assert system.CreateDefaultContext().is_stateless()
