"""What flies, wired: plant, scene graph, rotors and propellers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import SymbolicVectorSystem

from aerodrake.model.low_level.thrust_allocation import ThrustAllocation, allocate
from aerodrake.model.vehicle.payload import add_payload
from aerodrake.model.vehicle.vehicle import BASE_FRAME, VehicleModel, add_ground, add_robot
from aerodrake.scenario import Scenario
from aerodrake.support.errors import file_at
from aerodrake.systems.faults.actuators import make_rotor_faults
from aerodrake.systems.rotors import make_propellers, make_rotors


class Physics(NamedTuple):
    """Systems in a builder, connected with each other.

    Attributes:
        plant: Open: actuation, and forces beside those of propellers.
        scene_graph: Of the plant's geometry.
        rotors: Open: `u0`, commanded thrusts.
        thrust: (k) N, what the rotors really give.
        trim_thrust: (k,) N, those in trim.
    """

    plant: MultibodyPlant
    scene_graph: SceneGraph
    rotors: SymbolicVectorSystem
    thrust: OutputPort
    trim_thrust: np.ndarray


def add_physics(builder: DiagramBuilder, scenario: Scenario, vehicle: VehicleModel) -> Physics:
    """Adds the scenario's plant, with its payload and mismatch, in trim by default."""
    step, rotor = scenario.rates.plant_step_s, scenario.vehicle.rotor
    plant = builder.AddNamedSystem("plant", MultibodyPlant(step))
    scene_graph = builder.AddNamedSystem("scene_graph", SceneGraph())
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    with file_at(scenario.source, "vehicle.robot"):
        add_robot(plant, scenario.vehicle.robot, scenario.mismatch)
    add_payload(plant, scenario.payload.mass_kg)
    add_ground(plant)
    plant.SetUseSampledOutputPorts(False)  # With them a step would be an unrestricted update.
    plant.Finalize()
    plant.SetDefaultPositions(vehicle.trim_state[: plant.num_positions()])
    trim = allocate(ThrustAllocation.make(vehicle, rotor), vehicle.trim_wrench)
    rotors = builder.AddNamedSystem("rotors", make_rotors(rotor, scenario.mismatch, trim, step))
    base = plant.GetBodyByName(BASE_FRAME).index()
    propellers = builder.AddNamedSystem("propellers", make_propellers(rotor, vehicle.rotors, base))

    connect = builder.Connect
    connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    connect(scene_graph.get_query_output_port(), plant.get_geometry_query_input_port())
    rotor_faults = make_rotor_faults(scenario, len(trim))
    thrust = through(builder, rotors.get_output_port(), rotor_faults, "rotor_faults")
    connect(thrust, propellers.GetInputPort("command"))
    connect(plant.get_body_poses_output_port(), propellers.GetInputPort("body_poses"))
    connect(
        propellers.GetOutputPort("spatial_forces"), plant.get_applied_spatial_force_input_port()
    )
    return Physics(plant, scene_graph, rotors, thrust, trim)


def through(
    builder: DiagramBuilder, port: OutputPort, system: System | None, name: str
) -> OutputPort:
    """A port's signal after a system that is added to it by its name; the port itself if None."""
    if system is None:
        return port
    system = builder.AddNamedSystem(name, system)
    builder.Connect(port, system.get_input_port())
    return system.get_output_port()
