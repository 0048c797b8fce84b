"""Plant in MuJoCo as a system: its state, its inputs, and a landing, beside Drake's plant."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, System
from pydrake.systems.primitives import AffineSystem, ConstantVectorSource

from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Payload, Physics, Scenario
from aerodrake.wiring.plant import make_plant

STEP_S = 1e-3
ENGINES = ("drake", "mujoco")


def plant(vehicle: VehicleModel, engine: str) -> System:
    return make_plant(Scenario(physics=Physics(engine=engine)), vehicle)


def hovering(system: System, vehicle: VehicleModel) -> Simulator:
    """Returns a simulator of the plant with the vehicle's weight as thrust."""
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    fix(system, context, vehicle.mass * 9.81 / 4, vehicle)
    return simulator


def fix(system: System, context, thrust: float, vehicle: VehicleModel) -> None:
    """Sets the inputs to equal thrusts of the rotors, and the torques of trim."""
    system.GetInputPort("thrust").FixValue(context, np.full(4, thrust))
    system.GetInputPort("joint_torque").FixValue(context, vehicle.trim_torque)
    system.GetInputPort("generalized_force").FixValue(context, np.zeros(6 + vehicle.joints))


def state(system: System, context) -> np.ndarray:
    return system.GetOutputPort("state").Eval(context).copy()


def test_state_is_one_group_and_trim_by_default(vehicle):
    system = plant(vehicle, "mujoco")
    context = system.CreateDefaultContext()
    assert context.num_total_states() == len(vehicle.trim_state)
    np.testing.assert_array_equal(state(system, context), vehicle.trim_state)


def test_runs_and_clones_are_equal_bit_for_bit(vehicle):
    """One system, whose Contexts share MuJoCo's memory, advances them in turn."""
    system = plant(vehicle, "mujoco")
    first = hovering(system, vehicle)
    first.AdvanceTo(0.05)
    clone = Simulator(system, first.get_context().Clone())
    second = hovering(system, vehicle)
    first.AdvanceTo(0.1)
    second.AdvanceTo(0.1)
    clone.AdvanceTo(0.1)
    end = state(system, first.get_context())
    assert np.abs(end - vehicle.trim_state).max() > 1e-3
    for other in (second, clone):
        np.testing.assert_array_equal(state(system, other.get_context()), end)


@pytest.mark.parametrize("engine", ENGINES)
def test_inputs_act_in_the_step_at_whose_start_they_change(engine, vehicle):
    system = plant(vehicle, engine)
    simulator = hovering(system, vehicle)
    simulator.AdvanceTo(10 * STEP_S)
    context = simulator.get_mutable_context()
    fix(system, context, 0.0, vehicle)
    before = split_state(state(system, context)).v_B[2]
    simulator.AdvanceTo(11 * STEP_S - 1e-9)
    change = split_state(state(system, context)).v_B[2] - before
    assert change == pytest.approx(-9.81 * STEP_S, rel=0.1)


def test_body_poses_are_those_of_drake(vehicle):
    poses = []
    for engine in ENGINES:
        scenario = Scenario(physics=Physics(engine=engine), payload=Payload(mass_kg=0.1))
        system = make_plant(scenario, vehicle)
        poses.append(system.GetOutputPort("body_poses").Eval(system.CreateDefaultContext()))
    assert len(poses[0]) == len(poses[1]) == vehicle.plant.num_bodies() + 1
    for drake, mujoco in zip(*poses, strict=True):
        assert drake.IsNearlyEqualTo(mujoco, 1e-12)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_landing_comes_to_rest_on_the_feet(engine, vehicle):
    """From a height of 0.3 m without thrust, with tilt and speed; springs hold the tucked arm."""
    n, q = vehicle.joints, vehicle.tucked
    start = VehicleState.at_rest([0.0, 0.0, 0.3 - vehicle.feet_m], q, (0.1, -0.05, 0.4))
    start = start._replace(v_B=np.array([0.2, -0.1, 0.0]))
    builder = DiagramBuilder()
    system = builder.AddSystem(plant(replace(vehicle, working=q), engine))
    springs = np.zeros((n, VehicleState.size(n)))
    springs[:, 7 : 7 + n], springs[:, 13 + n :] = -30 * np.eye(n), -np.eye(n)
    arm = builder.AddSystem(AffineSystem(D=springs, y0=30 * q))
    zeros = {"thrust": np.zeros(4), "generalized_force": np.zeros(6 + n)}
    for name, value in zeros.items():
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    builder.Connect(system.GetOutputPort("state"), arm.get_input_port())
    builder.Connect(arm.get_output_port(), system.GetInputPort("joint_torque"))
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    context.SetDiscreteState(start.to_vector())
    simulator = Simulator(diagram, context)
    simulator.AdvanceTo(2.5)
    end = split_state(state(system, system.GetMyContextFromRoot(context)))
    rates = np.concatenate([end.omega_W, end.v_B, end.qdot])
    assert np.abs(rates).max() < 1e-3
    assert end.p_B[2] == pytest.approx(-vehicle.feet_m, abs=1e-3)
    assert np.abs(end.rpy[:2]).max() < 5e-3 and np.linalg.norm(end.p_B[:2]) < 0.3
