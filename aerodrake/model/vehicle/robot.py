"""Robots as parts of plants: description, mismatch, payload and ground."""

import math
from dataclasses import dataclass, field
from typing import Self
from xml.dom.minidom import Document, Element

import numpy as np
from pydrake.geometry import HalfSpace, SceneGraph, SceneGraphConfig, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RevoluteJoint, SpatialInertia

from aerodrake.model.vehicle.drake_parser import parse_urdf
from aerodrake.model.vehicle.urdf_joints import check_joints
from aerodrake.model.vehicle.urdf_links import check_links
from aerodrake.model.vehicle.urdf_numbers import MOMENTS, check_numbers
from aerodrake.scenario import Mismatch
from aerodrake.support.errors import BadInput
from aerodrake.support.files import locate
from aerodrake.support.urdf import read_urdf
from aerodrake.support.urdf_element import child, children, numbers

BASE_FRAME = "base"
"""Link of the base in the URDF; its frame is B."""
TOOL_FRAME = "tool"
"""Frame of the tool in the URDF; its origin is the end-effector, E."""
TOOL_AXIS = np.array([0.0, 0.0, -1.0])
"""Direction in which the tool approaches objects, in the tool frame."""
EXACT = Mismatch()
"""No mismatch."""
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
            BadInput: if the file is missing or no URDF; if a number, link or joint of it is
                invalid.
        """
        try:
            document = read_urdf(locate(robot))
            root = document.documentElement
            check_numbers(root)
            check_links(root, BASE_FRAME)
            check_joints(root, BASE_FRAME, TOOL_FRAME)
        except BadInput as error:
            raise BadInput(robot, *error.args[1:]) from None
        return cls(robot, document)

    @property
    def has_collision_geometry(self) -> bool:
        """True if a link can touch the ground or another link."""
        return bool(self.document.getElementsByTagName("collision"))

    def invisible_urdf(self, mismatch: Mismatch) -> str:
        """Returns the URDF without visual geometry, most of which is meshes to be read.

        The mass and central inertia of every link are scaled, and the base's centre of mass is
        moved. The numbers are changed in the description, since a body welded to a link could not
        add to its mass without adding to its inertia.

        Raises:
            BadInput: if a base without mass has a centre of mass to move.
        """
        robot = self.document.documentElement
        invisible = robot.cloneNode(deep=False)
        for element in children(robot):
            copy = element.cloneNode(deep=element.tagName != "link")
            if element.tagName == "link":
                for part in children(element):
                    if part.tagName != "visual":
                        copy.appendChild(part.cloneNode(deep=True))
            invisible.appendChild(copy)
        if mismatch.mass_scale != 1 or mismatch.inertia_scale != 1:
            for link in children(invisible, "link"):
                for inertial in children(link, "inertial"):
                    _scale(child(inertial, "mass"), ("value",), mismatch.mass_scale)
                    _scale(child(inertial, "inertia"), MOMENTS, mismatch.inertia_scale)
        if any(mismatch.centre_of_mass_m):
            links = children(invisible, "link")
            base = next(link for link in links if link.getAttribute("name") == BASE_FRAME)
            if (inertial := child(base, "inertial")) is None:
                problem = "expected a mass, whose centre mismatch.centre_of_mass_m can move"
                raise BadInput(self.robot, f"link {BASE_FRAME}", problem)
            _move(inertial, mismatch.centre_of_mass_m)
        return invisible.toxml()


def _scale(element: Element, attributes: tuple[str, ...], factor: float) -> None:
    for name in attributes:
        element.setAttribute(name, repr(factor * float(element.getAttribute(name))))


def _move(inertial: Element, offset: tuple[float, ...]) -> None:
    """Adds an offset (3,) m to the centre of mass of an inertial element."""
    origin = child(inertial, "origin")
    if origin is None:
        origin = inertial.appendChild(inertial.ownerDocument.createElement("origin"))
    centre = numbers(origin, "xyz", "0 0 0")
    origin.setAttribute("xyz", " ".join(repr(p + d) for p, d in zip(centre, offset, strict=True)))


def add_robot(
    plant: MultibodyPlant, description: RobotDescription, mismatch: Mismatch = EXACT
) -> None:
    """Adds a robot without visual geometry to an unfinalised plant.

    In a plant that is registered with a SceneGraph it has its collision geometry.

    Args:
        plant: The plant.
        description: The robot.
        mismatch: Factors of its links' masses and inertias, and offset of the base's
            centre of mass.

    Raises:
        BadInput: if Drake cannot parse it, or a base without mass has a centre of mass to move.
    """
    parse_urdf(plant, description.invisible_urdf(mismatch), description.robot)


def add_visible_robot(plant: MultibodyPlant, description: RobotDescription) -> None:
    """Adds a robot with visual geometry, as `add_robot` otherwise does."""
    parse_urdf(plant, description.document.toxml(), description.robot)


def arm_joints(plant: MultibodyPlant) -> list[RevoluteJoint]:
    """Returns the joints of a robot's arm, from the base to the tool.

    Args:
        plant: The finalised plant, which contains the robot alone.
    """
    joints = map(plant.get_joint, plant.GetJointIndices())
    arm = [joint for joint in joints if isinstance(joint, RevoluteJoint)]
    return sorted(arm, key=RevoluteJoint.position_start)  # The file may have another order.


def add_payload(plant: MultibodyPlant, mass: float) -> None:
    """Welds a steel ball to the tool of an unfinalised plant that contains a robot.

    The controllers' model does not include it. The ball's centre is the origin of the tool
    frame. It has mass and inertia, but no geometry.

    Args:
        plant: The plant; the ball becomes its last body.
        mass: kg; 0 adds nothing.
    """
    if mass == 0:
        return
    radius = ball_radius(mass, STEEL_KG_M3)
    inertia = SpatialInertia.SolidSphereWithMass(mass, radius)
    body = plant.AddRigidBody(PAYLOAD_BODY, plant.AddModelInstance(PAYLOAD_BODY), inertia)
    plant.WeldFrames(plant.GetFrameByName(TOOL_FRAME), body.body_frame())


def add_visible_payload(plant: MultibodyPlant, mass: float) -> None:
    """Adds a payload as `add_payload` does, and the ball's visual geometry."""
    add_payload(plant, mass)
    if mass > 0:
        ball, body = Sphere(ball_radius(mass, STEEL_KG_M3)), plant.GetBodyByName(PAYLOAD_BODY)
        plant.RegisterVisualGeometry(body, RigidTransform(), ball, PAYLOAD_BODY, STEEL_COLOR)


def ball_radius(mass: float, density: float) -> float:
    """Returns the radius in m of a solid ball; mass in kg, density in kg/m^3."""
    return (3 * mass / (4 * math.pi * density)) ** (1 / 3)


def make_scene_graph() -> SceneGraph:
    """Makes a SceneGraph for point contact of rigid bodies."""
    config = SceneGraphConfig()
    # Without a resolution Drake makes no meshes for deformable bodies, which half spaces lack.
    config.default_proximity_properties.resolution_hint = None
    return SceneGraph(config)


def add_ground(plant: MultibodyPlant) -> None:
    """Adds the ground, the half space below z = 0, to a plant registered with a SceneGraph."""
    friction = CoulombFriction(static_friction=0.8, dynamic_friction=0.6)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground_collision", friction
    )


def make_nominal_plant(description: RobotDescription) -> tuple[MultibodyPlant, SceneGraph]:
    """Makes a finalised plant of the robot alone, and the SceneGraph with its collision geometry.

    Raises:
        BadInput: if Drake cannot parse the robot.
    """
    plant, scene_graph = MultibodyPlant(0.0), make_scene_graph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    add_robot(plant, description)
    plant.Finalize()
    return plant, scene_graph
