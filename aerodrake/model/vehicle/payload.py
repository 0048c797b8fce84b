"""Payload at the end-effector: part of the plant, but not of the controllers' model."""

import math

from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from aerodrake.model.vehicle.robot import TOOL_FRAME

STEEL_KG_M3 = 7850.0
"""Density of the payload, which determines its size."""
STEEL_COLOR = (0.55, 0.57, 0.60, 1.0)
PAYLOAD_BODY = "payload"


def add_payload(plant: MultibodyPlant, mass: float) -> None:
    """Welds a steel ball to the tool of an unfinalised plant that contains a robot.

    The ball's centre is the origin of the tool frame. It has mass and inertia, but no
    collision geometry; in a plant that is registered with a SceneGraph it is visible.

    Args:
        plant: The plant; the ball becomes its last body.
        mass: kg; 0 adds nothing.
    """
    if mass == 0:
        return
    radius = (3 * mass / (4 * math.pi * STEEL_KG_M3)) ** (1 / 3)
    body = plant.AddRigidBody(
        PAYLOAD_BODY,
        plant.AddModelInstance(PAYLOAD_BODY),
        SpatialInertia.SolidSphereWithMass(mass, radius),
    )
    plant.WeldFrames(plant.GetFrameByName(TOOL_FRAME), body.body_frame())
    if plant.geometry_source_is_registered():
        plant.RegisterVisualGeometry(
            body, RigidTransform(), Sphere(radius), PAYLOAD_BODY, STEEL_COLOR
        )
