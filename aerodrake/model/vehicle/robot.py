"""Robots as parts of plants: description, mismatch, payload and ground."""

import math
import re
from dataclasses import dataclass, field
from importlib import resources
from typing import Self
from xml.dom.minidom import Document, Element

import numpy as np
from pydrake.geometry import Box, SceneGraph, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from aerodrake.scenario import Mismatch
from aerodrake.support.errors import BadInput
from aerodrake.support.files import locate
from aerodrake.support.urdf import SUFFIX, read_urdf

BASE_FRAME = "base"
"""Link of the base in the URDF; its frame is B."""
TOOL_FRAME = "tool"
"""Frame of the tool in the URDF; its origin is the end-effector, E."""
TOOL_AXIS = np.array([0.0, 0.0, -1.0])
"""Direction in which the tool approaches objects, in the tool frame."""
EXACT = Mismatch()
"""No mismatch."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of `<inertia>` in a URDF."""
PAYLOAD_BODY = "payload"
STEEL_KG_M3 = 7850.0
"""Density of the payload, which determines its size."""
STEEL_COLOR = (0.55, 0.57, 0.60, 1.0)


@dataclass(frozen=True)
class RobotDescription:
    """A URDF, read and parsed as XML once for all plants that contain the robot.

    Attributes:
        robot: Its `package://aerodrake/...` URI or path.
        document: Its XML; meshes beside the file are named by absolute URIs.
    """

    robot: str
    document: Document = field(repr=False)

    @classmethod
    def read(cls, robot: str) -> Self:
        """Reads a URDF.

        Args:
            robot: A `package://aerodrake/...` URI, or the path of a URDF.

        Raises:
            BadInput: if the file is missing or is no URDF.
        """
        try:
            return cls(robot, read_urdf(locate(robot)))
        except BadInput as error:
            raise BadInput(robot, *error.args[1:]) from None

    def urdf(self, mismatch: Mismatch) -> str:
        """Returns the URDF with the mass and central inertia of every link scaled.

        The numbers are scaled in the description, since a body welded to a link could not
        add to its mass without adding to its inertia.

        Raises:
            BadInput: if a number in the file is malformed.
        """
        if mismatch.mass_scale == mismatch.inertia_scale == 1:
            return self.document.toxml()
        document = self.document.cloneNode(deep=True)
        try:
            for link in document.getElementsByTagName("inertial"):
                for mass in link.getElementsByTagName("mass"):
                    _scale(mass, ("value",), mismatch.mass_scale)
                for inertia in link.getElementsByTagName("inertia"):
                    _scale(inertia, MOMENTS, mismatch.inertia_scale)
        except ValueError as error:
            raise BadInput(self.robot, "", f"mismatch of links: {error}") from None
        return document.toxml()


def _scale(element: Element, attributes: tuple[str, ...], factor: float) -> None:
    for name in attributes:
        if element.hasAttribute(name):
            element.setAttribute(name, repr(factor * float(element.getAttribute(name))))


def add_robot(
    plant: MultibodyPlant, description: RobotDescription, mismatch: Mismatch = EXACT
) -> None:
    """Adds a robot to an unfinalised plant, with factors of its links' masses and inertias.

    Raises:
        BadInput: if Drake cannot parse it, or it lacks the frames `base` and `tool`.
    """
    robot, parser = description.robot, Parser(plant)
    parser.package_map().AddPackageXml(str(resources.files("aerodrake") / "package.xml"))
    try:
        parser.AddModelsFromString(description.urdf(mismatch), SUFFIX)
    except (RuntimeError, ValueError, SystemExit) as error:  # Drake's own, and its conditions.
        problem = re.sub(r"<literal-string>\S*: error: ", "", str(error))
        raise BadInput(robot, "", f"cannot be parsed: {problem}") from None
    for frame in (BASE_FRAME, TOOL_FRAME):
        if not plant.HasFrameNamed(frame):
            raise BadInput(robot, "", f"expected a frame named '{frame}'")
    if not plant.HasBodyNamed(BASE_FRAME):
        raise BadInput(robot, "", f"expected '{BASE_FRAME}' to be a link")


def add_payload(plant: MultibodyPlant, mass: float) -> None:
    """Welds a steel ball to the tool of an unfinalised plant that contains a robot.

    The controllers' model does not include it. The ball's centre is the origin of the tool
    frame. It has mass and inertia, but no collision geometry; in a plant that is registered
    with a SceneGraph it is visible.

    Args:
        plant: The plant; the ball becomes its last body.
        mass: kg; 0 adds nothing.
    """
    if mass == 0:
        return
    radius = (3 * mass / (4 * math.pi * STEEL_KG_M3)) ** (1 / 3)
    inertia = SpatialInertia.SolidSphereWithMass(mass, radius)
    body = plant.AddRigidBody(PAYLOAD_BODY, plant.AddModelInstance(PAYLOAD_BODY), inertia)
    plant.WeldFrames(plant.GetFrameByName(TOOL_FRAME), body.body_frame())
    if plant.geometry_source_is_registered():
        ball, pose = Sphere(radius), RigidTransform()
        plant.RegisterVisualGeometry(body, pose, ball, PAYLOAD_BODY, STEEL_COLOR)


def add_ground(plant: MultibodyPlant) -> None:
    """Adds ground at z = 0 to a plant that is registered with a SceneGraph."""
    slab = Box(100.0, 100.0, 1.0)
    pose = RigidTransform([0.0, 0.0, -0.5])
    friction = CoulombFriction(static_friction=0.8, dynamic_friction=0.6)
    plant.RegisterCollisionGeometry(plant.world_body(), pose, slab, "ground_collision", friction)


def make_nominal_plant(description: RobotDescription) -> tuple[MultibodyPlant, SceneGraph]:
    """Makes a finalised plant of the robot alone, and the SceneGraph with its geometry."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, description)
    plant.Finalize()
    return plant, scene_graph
