"""A load at the end-effector: part of the plant, but of no controller's model."""

from __future__ import annotations

import math

from pydrake.geometry import Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from aerodrake.model.vehicle.vehicle import TOOL_FRAME

STEEL_KG_M3 = 7850.0
"""Density, from which the payload has its size."""
STEEL_COLOR = (0.55, 0.57, 0.60, 1.0)
PAYLOAD_BODY = "payload"


def add_payload(plant: MultibodyPlant, mass: float) -> None:
    """Welds a steel ball to the tool of an unfinalised plant that has a robot.

    Its centre is the origin of the tool frame. It weighs and has inertia, but
    touches nothing; where the plant is registered with a SceneGraph it is seen.

    Args:
        plant: Where it goes; it comes after the bodies that are there.
        mass: kg; with 0 nothing is added.
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
