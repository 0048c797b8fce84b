"""The physics alone: what a closed loop is compared with in cost."""

from __future__ import annotations

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from aerodrake.model.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle import BASE_FRAME, Vehicle, add_ground, add_robot
from aerodrake.scenario import Scenario
from aerodrake.systems.rotors import make_propellers, make_rotors


def make_bare_plant(scenario: Scenario) -> Diagram:
    """The station's plant, scene graph, propellers and rotors, at the constant input of trim.

    Nothing in it is Python, and nothing holds the vehicle: it drifts off slowly, as
    rounding has it. Outputs: `true_state` (13 + 2 n).
    """
    rates, rotor = scenario.rates, scenario.vehicle.rotor
    vehicle = Vehicle.load(scenario)
    builder = DiagramBuilder()

    plant = builder.AddNamedSystem("plant", MultibodyPlant(rates.plant_step_s))
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, scenario.vehicle.robot)
    add_ground(plant)
    plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    plant.SetDefaultPositions(vehicle.trim_state[: plant.num_positions()])
    trim = allocate(ThrustAllocation.make(vehicle, rotor), vehicle.trim_wrench)
    rotors = builder.AddNamedSystem(
        "rotors", make_rotors(rotor, scenario.mismatch, trim, rates.plant_step_s)
    )
    base = plant.GetBodyByName(BASE_FRAME).index()
    propellers = builder.AddNamedSystem("propellers", make_propellers(rotor, vehicle.rotors, base))
    thrust_command = builder.AddNamedSystem("thrust_command", ConstantVectorSource(trim))
    joint_torque = builder.AddNamedSystem("joint_torque", ConstantVectorSource(vehicle.trim_torque))

    connect = builder.Connect
    connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    connect(scene_graph.get_query_output_port(), plant.get_geometry_query_input_port())
    connect(thrust_command.get_output_port(), rotors.get_input_port())
    connect(rotors.get_output_port(), propellers.get_command_input_port())
    connect(plant.get_body_poses_output_port(), propellers.get_body_poses_input_port())
    connect(
        propellers.get_spatial_forces_output_port(), plant.get_applied_spatial_force_input_port()
    )
    connect(joint_torque.get_output_port(), plant.get_actuation_input_port())
    builder.ExportOutput(plant.get_state_output_port(), "true_state")
    diagram = builder.Build()
    diagram.set_name("bare_plant")
    return diagram
