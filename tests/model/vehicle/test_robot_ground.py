"""The ground has no edge, and no depth that a fast vehicle could cross."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from aerodrake.model.vehicle.robot import add_ground, add_robot, make_scene_graph
from aerodrake.model.vehicle.state import VehicleState, split_state


@pytest.fixture(scope="module")
def fall(vehicle):
    """Returns a function that simulates a fall, and returns the base's final position (3,) m."""
    builder = DiagramBuilder()
    plant = builder.AddNamedSystem("plant", MultibodyPlant(1e-3))
    scene_graph = builder.AddNamedSystem("scene_graph", make_scene_graph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, vehicle.description)
    add_ground(plant)
    plant.Finalize()
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    builder.Connect(scene_graph.get_query_output_port(), plant.get_geometry_query_input_port())
    diagram = builder.Build()

    def fall(p_B: np.ndarray, speed: float, seconds: float) -> np.ndarray:
        context = diagram.CreateDefaultContext()
        inner = plant.GetMyMutableContextFromRoot(context)
        state = VehicleState.at_rest(p_B, vehicle.tucked)
        state = state._replace(v_B=np.array([0.0, 0.0, -speed]))
        plant.SetPositionsAndVelocities(inner, state.to_vector())
        plant.get_actuation_input_port().FixValue(inner, vehicle.trim_torque)
        Simulator(diagram, context).AdvanceTo(seconds)
        return split_state(plant.GetPositionsAndVelocities(inner)).p_B

    return fall


@pytest.mark.parametrize("x", [0.0, 49.9, 80.0, 5000.0])
def test_the_vehicle_rests_on_its_feet_anywhere(x, vehicle, fall):
    p_B = fall(np.array([x, -x, -vehicle.feet_m + 0.001]), 0.0, 0.2)
    assert p_B[2] == pytest.approx(-vehicle.feet_m, abs=2e-3)
    assert abs(p_B[0] - x) < 0.01


def test_a_fast_vehicle_does_not_cross_it(vehicle, fall):
    """At 100 m/s it would leave a slab of 1 m within 10 ms."""
    p_B = fall(np.array([0.0, 0.0, 1.0]), 100.0, 0.1)
    assert p_B[2] > -0.5
