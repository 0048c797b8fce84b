"""URDF of a vehicle: a multirotor's base with a converted arm."""

from dataclasses import dataclass
from xml.dom.minidom import Element

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from aerodrake.model.vehicle.robot import BASE_FRAME, TOOL_AXIS, TOOL_FRAME
from aerodrake.mounting.airframe import base_urdf
from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.elements import (
    arm_elements,
    decimals,
    element,
    filter_element,
    joint_element,
)
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.names import MOUNT
from aerodrake.mounting.pose import Pose
from aerodrake.mounting.sizing import Multirotor
from aerodrake.mounting.tool import Tool

XMLNS = "https://drake.mit.edu"


@dataclass(frozen=True)
class VehicleDesign:
    """Arm below a multirotor.

    Attributes:
        arm: The arm, converted.
        tool: Its tool; the link's name is that after the conversion.
        multirotor: The multirotor.
        mount: Pose of the arm's first link in the base's frame.
        is_filtered: True if its links do not collide with each other, as in flight.
    """

    arm: ArmTree
    tool: Tool
    multirotor: Multirotor
    mount: Pose
    is_filtered: bool = True

    def urdf(self, notes: tuple[str, ...] = ()) -> str:
        """Returns the URDF, with a comment of one line for each note at its start."""
        mount = ArmJoint(MOUNT, "fixed", BASE_FRAME, self.arm.root, self.mount)
        links = [BASE_FRAME, *(link.name for link in self.arm.links)]
        sections = [
            ("Mount of the arm.", [joint_element(mount)]),
            ("Arm: links, joints and motors.", arm_elements(self.arm, self.tool.link)),
            ("Tool: the end-effector, which points along -z.", [self._tool_frame()]),
            (
                "The vehicle does not collide with itself; contact with the ground stays.",
                [filter_element(links)] if self.is_filtered else [],
            ),
        ]
        header = [_comment(note) for note in notes]
        body = [_section(title, elements) for title, elements in sections if elements]
        robot = f'<robot name="{self.arm.name}" xmlns:drake="{XMLNS}">'
        parts = ['<?xml version="1.0"?>\n', *header, f"{robot}\n", base_urdf(self.multirotor)]
        return "".join([*parts, *body, "</robot>\n"])

    def _tool_frame(self) -> Element:
        pose = Pose.of(RigidTransform(_rotation_of(self.tool.direction), self.tool.position))
        xyz, rpy = (decimals(np.round(part, 9).tolist()) for part in pose)
        return element("frame", name=TOOL_FRAME, link=self.tool.link, xyz=xyz, rpy=rpy)


def _rotation_of(direction: np.ndarray) -> RotationMatrix:
    """Returns a rotation of a frame whose axis `TOOL_AXIS` has a direction (3,)."""
    z = -np.array(direction) if TOOL_AXIS[2] < 0 else np.array(direction)
    if z[2] < 0 and np.allclose(z[:2], 0):
        return RollPitchYaw(np.pi, 0, 0).ToRotationMatrix()
    return RotationMatrix.MakeFromOneVector(z, 2) if z[2] < 1 else RotationMatrix()


def _section(title: str, elements: list[Element]) -> str:
    text = "".join(part.toprettyxml(indent="  ") for part in elements)
    lines = [f"  {line}\n" for line in text.splitlines()]
    return "".join([f"  {_comment(title)}", *lines])


def _comment(text: str) -> str:
    """Returns an XML comment, which cannot have two hyphens."""
    return f"<!-- {text.replace('--', '- -')} -->\n"
