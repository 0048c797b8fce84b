"""Tests of the orientation task as a system and in the coordinator."""

import math

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from aerodrake.model.reference.direction import make_direction
from aerodrake.model.vehicle.robot import TOOL_FRAME, add_robot
from aerodrake.scenario import AxisAlong, FixedAxis, Scenario
from aerodrake.station import make_coordinator
from aerodrake.support.errors import BadInput
from aerodrake.systems.pointing import PointingSystem

SETTLE_S, STAGES_S = 1.0, np.array([0.0, 0.02, 0.06])


@pytest.fixture(scope="module")
def direction(tmp_path_factory):
    file = tmp_path_factory.mktemp("pointing") / "d.csv"
    file.write_text("t,ax,ay,az\n0,0,0,-1\n1,0,1,-1\n2,1,0,-1\n")
    return make_direction(AxisAlong(file=str(file)))


@pytest.fixture(scope="module")
def system(vehicle, direction) -> PointingSystem:
    return PointingSystem(vehicle, direction, SETTLE_S, STAGES_S)


def test_outputs_are_of_the_current_state_and_time(system, vehicle, direction):
    plant = MultibodyPlant(0.0)
    add_robot(plant, vehicle.description)
    plant.Finalize()
    plant_context = plant.CreateDefaultContext()
    context, rng = system.CreateDefaultContext(), np.random.default_rng(0)
    for time in (0.0, 1.7, 2.2):  # One context: its cache must not go stale.
        x = vehicle.trim_state + 0.2 * rng.normal(size=len(vehicle.trim_state))
        x[:4] /= np.linalg.norm(x[:4])
        system.GetInputPort("state").FixValue(context, x)
        plant.SetPositionsAndVelocities(plant_context, x)
        R_WE = plant.GetFrameByName(TOOL_FRAME).CalcPoseInWorld(plant_context).rotation()
        for later in (time, time + 0.3):  # At the same state.
            context.SetTime(later)
            pointing = system.GetOutputPort("pointing").Eval(context)
            np.testing.assert_allclose(pointing.axis.value, -R_WE.matrix()[:, 2], atol=1e-12)
            d, rate = direction.evaluate(round(later - SETTLE_S, 9) + STAGES_S)
            np.testing.assert_array_equal(pointing.reference, np.hstack([d, rate]))
            horizon = system.GetOutputPort("tool_axis_horizon").Eval(context)
            np.testing.assert_array_equal(horizon, pointing.reference.ravel())
            tool_axis_d = system.GetOutputPort("tool_axis_d").Eval(context)
            np.testing.assert_array_equal(tool_axis_d, d[0])


def test_pointing_feeds_through_and_the_system_has_no_state(system):
    feedthrough = [
        system.HasDirectFeedthrough(0, system.GetOutputPort(port).get_index())
        for port in ("pointing", "tool_axis_horizon", "tool_axis_d")
    ]
    assert feedthrough == [True, False, False]
    assert system.CreateDefaultContext().is_stateless()


def test_the_coordinator_has_it_only_with_an_orientation_task():
    without = make_coordinator(Scenario())
    assert not without.HasSubsystemNamed("pointing")
    assert not without.HasOutputPort("tool_axis_d")
    assert not without.HasOutputPort("tool_axis_horizon")
    coordinator = make_coordinator(Scenario(orientation=FixedAxis()))
    assert coordinator.HasSubsystemNamed("pointing")
    assert coordinator.GetOutputPort("tool_axis_d").size() == 3


def test_the_mpc_turns_the_tool_towards_the_desired_direction(vehicle):
    """Desired directions to either side of the tool give opposite joint accelerations."""
    moves = []
    for side in (1.0, -1.0):
        scenario = Scenario(settle_s=0.0, orientation=FixedAxis(axis=(0.0, side * 0.1, -1.0)))
        coordinator = make_coordinator(scenario)
        mpc = coordinator.GetSubsystemByName("mpc")
        context = coordinator.CreateDefaultContext()
        coordinator.GetInputPort("state").FixValue(context, vehicle.trim_state)
        coordinator.GetInputPort("specific_thrust").FixValue(context, [9.81])
        coordinator.GetInputPort("disturbance").FixValue(context, np.zeros(6))
        coordinator.GetInputPort("external_acceleration").FixValue(context, np.zeros(3))
        coordinator.GetInputPort("saturated").FixValue(context, [0.0])
        inner = mpc.GetMyMutableContextFromRoot(context)
        inner.SetDiscreteState(mpc.EvalUniquePeriodicDiscreteUpdate(inner))
        qddot = mpc.GetOutputPort("u").Eval(inner)[3:]
        pitch = [i for i, name in enumerate(vehicle.joint_names) if name.endswith("pitch")]
        moves.append(qddot[pitch].sum())
    # The pitch joints turn about x, and so the tool, which points down, towards +y.
    assert moves[0] > 0.1 and moves[1] < -0.1
    assert math.isclose(moves[0], -moves[1], rel_tol=0.3)


def test_refuses_a_direction_behind_the_tool(vehicle):
    with pytest.raises(BadInput, match="180.0 deg"):
        PointingSystem(vehicle, make_direction(FixedAxis(axis=(0.0, 0.0, 1.0))), 0.0, STAGES_S)
