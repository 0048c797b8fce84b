"""Robot descriptions, and robots as parts of plants."""

import re
from dataclasses import dataclass, field
from importlib import resources
from typing import Self
from xml.dom.minidom import Document

import numpy as np
from pydrake.geometry import Box, SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from aerodrake.model.vehicle.mismatch import EXACT, scaled_urdf
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


def add_robot(
    plant: MultibodyPlant, description: RobotDescription, mismatch: Mismatch = EXACT
) -> None:
    """Adds a robot to an unfinalised plant.

    Args:
        plant: The plant.
        description: The robot.
        mismatch: Factors of its links' masses and inertias.

    Raises:
        BadInput: if Drake cannot parse it, or it lacks the frames `base` and `tool`.
    """
    robot, parser = description.robot, Parser(plant)
    parser.package_map().AddPackageXml(str(resources.files("aerodrake") / "package.xml"))
    try:
        parser.AddModelsFromString(scaled_urdf(robot, description.document, mismatch), SUFFIX)
    except (RuntimeError, ValueError, SystemExit) as error:  # Drake's own, and its conditions.
        problem = re.sub(r"<literal-string>\S*: error: ", "", str(error))
        raise BadInput(robot, "", f"cannot be parsed: {problem}") from None
    for frame in (BASE_FRAME, TOOL_FRAME):
        if not plant.HasFrameNamed(frame):
            raise BadInput(robot, "", f"expected a frame named '{frame}'")
    if not plant.HasBodyNamed(BASE_FRAME):
        raise BadInput(robot, "", f"expected '{BASE_FRAME}' to be a link")


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
