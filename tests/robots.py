"""Plants of robots with mismatch or payload."""

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, Diagram

from aerodrake.gallery.graph import systems_by_name
from aerodrake.model.vehicle.robot import RobotDescription, add_payload, add_robot
from aerodrake.scenario import Mismatch


def make_plant(
    robot: str, scene_graph: SceneGraph, mismatch: Mismatch | None = None, payload_kg: float = 0.0
) -> MultibodyPlant:
    plant = MultibodyPlant(0.001)
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, RobotDescription.read(robot), mismatch or Mismatch())
    add_payload(plant, payload_kg)
    plant.Finalize()
    return plant


def multibody_plant(diagram: Diagram) -> MultibodyPlant:
    """Returns Drake's plant in a diagram, at any depth."""
    return systems_by_name(diagram)["multibody_plant"]


def at(plant: MultibodyPlant, state: np.ndarray) -> Context:
    """Returns a Context of the plant at a state."""
    context = plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, state)
    return context
