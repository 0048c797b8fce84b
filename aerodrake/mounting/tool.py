"""Tool of an arm: the link at the end of its chain, and the direction it points in."""

import itertools
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from aerodrake.mounting.arm import ArmJoint, ArmTree
from aerodrake.support.errors import BadInput, nearest

FINGER = re.compile(r"finger|jaw|claw|thumb|knuckle|index|pinky", re.IGNORECASE)
"""Names of parts of a gripper, and of joints that move them."""
GRIPPER = re.compile(rf"^(?!.*(roll|rot|wrist)).*(grip|hand|{FINGER.pattern})", re.IGNORECASE)
"""Names of joints of a gripper, but not of the wrist that turns it."""
MARKERS = (
    re.compile(r"tcp|grasp|pinch", re.IGNORECASE),
    re.compile(r"(^|_)tool0?$", re.IGNORECASE),
    re.compile(r"(^|_)(eef|ee|end_?effector)($|_)", re.IGNORECASE),
    re.compile(r"tip|tool|gripper|flange", re.IGNORECASE),
)
"""Names of frames at the tool, the closest to an object first."""
FRAME_KG = 1e-3
"""Largest mass of a link that marks a frame."""
SMALL_M = 1e-3
"""Distance up to which origins coincide."""
ALONG_AXIS = 0.5
"""Smallest cosine between a last joint's axis and the offset of a tool that points along it."""
ALIGNED = 0.98
"""Cosine, of 11 deg, above which a direction is taken for that of an axis of the link."""
LAST = "the last link of the chain"
"""Reason for a tool without a frame of its own."""


@dataclass(frozen=True)
class Tool:
    """Tool of an arm.

    Attributes:
        link: Name of its link.
        position: (3,) m, the end-effector in the link's frame.
        direction: (3,) unit vector along which it points, in the link's frame.
        reason: Clause that says how it was chosen.
    """

    link: str
    position: np.ndarray
    direction: np.ndarray
    reason: str

    @classmethod
    def of(cls, arm: ArmTree, wanted: str = "") -> Self:
        """Returns the given link as tool, or guesses one.

        Without a name it is the frame with a well-known name, such as tool0 or hand_tcp, after the
        largest number of joints, or else the end of the last link there, twice as far as its
        centre of mass. Joints of a gripper do not count.

        Args:
            arm: The arm as in its URDF.
            wanted: Name of the link; empty to guess.

        Raises:
            BadInput: if there is no such link, or no revolute joint above it.
        """
        names = [link.name for link in arm.links]
        if wanted and wanted not in names:
            problem = f"expected a link, got '{wanted}'; {nearest(wanted, names)}"
            raise BadInput("tool", "", problem)
        link, reason = (wanted, "as given") if wanted else _guess(arm)
        if not arm.moving(link):
            problem = f"expected a link with revolute joints above it, got '{link}' without"
            raise BadInput("tool", "", problem)
        end = 2 * _centre(arm, link) if reason == LAST else np.zeros(3)
        direction = _direction(arm, link, end)
        return cls(link, max(0.0, end @ direction) * direction, direction, reason)


def _joints(path: Sequence[ArmJoint]) -> list[ArmJoint]:
    """Returns the moving joints of a path without those at its end that move a gripper.

    If there are no others, only joints that follow another one are left out.
    """
    moving = [joint for joint in path if joint.is_moving]
    arm = list(itertools.dropwhile(_of_gripper, reversed(moving)))[::-1]
    return arm or [joint for joint in moving if joint.mimic is None]


def _after(path: Sequence[ArmJoint], own: Sequence[ArmJoint]) -> list[ArmJoint]:
    """Returns the joints of a path after the last one of the arm's own."""
    return [*itertools.takewhile(lambda joint: joint not in own[-1:], reversed(path))]


def _of_gripper(joint: ArmJoint) -> bool:
    """Returns True if a joint moves a part of a gripper."""
    named = GRIPPER.search(joint.name) or FINGER.search(joint.child)
    return joint.mimic is not None or bool(named)


def _guess(arm: ArmTree) -> tuple[str, str]:
    """Returns the link of the tool and the reason."""
    counts = {}
    for link in arm.links:
        own = _joints(arm.path(link.name))
        beyond = [joint for joint in _after(arm.path(link.name), own) if joint.kind != "fixed"]
        counts[link.name] = 0 if beyond else len(own)
    most = max(counts.values())
    last = [name for name, count in counts.items() if count == most]
    tips = set(arm.tips())
    markers = [name for name in last if name in tips and arm.link(name).mass <= FRAME_KG]
    for pattern in MARKERS:
        for name in markers:
            if pattern.search(name):
                return name, "the frame with this name after the last joint"
    if len(markers) == 1:
        return markers[0], "the only link without mass after the last joint"
    link = last[0]
    while len(below := [j.child for j in arm.joints if j.parent == link and j.child in last]) == 1:
        link = below[0]
    return link, LAST


def _centre(arm: ArmTree, link: str) -> np.ndarray:
    """Returns the centre of mass (3,) m of a link; its origin if it has no mass."""
    inertial = arm.link(link).inertial
    return np.array(inertial.origin.xyz) if inertial else np.zeros(3)


def _direction(arm: ArmTree, link: str, end: np.ndarray) -> np.ndarray:
    """Returns the direction (3,) of a tool in its link's frame.

    It is the axis of the last joint, towards the tool, or if that is across the last link, as in
    planar arms, the direction from the last joint to the tool.

    Args:
        arm: The arm.
        link: Name of the tool's link.
        end: (3,) m, the tool in the link's frame.
    """
    poses = arm.poses()
    joints = _joints(arm.path(link))[::-1]
    # Origins of the joints in the link's frame, all at zero.
    X_ET = poses[link].inverse()
    offsets = (end - X_ET.multiply(poses[joint.child].translation()) for joint in joints)
    axis = (X_ET @ poses[joints[0].child]).rotation() @ np.array(joints[0].axis)
    axis = axis / np.linalg.norm(axis)
    offset = next((d for d in offsets if np.linalg.norm(d) > SMALL_M), axis)
    direction = offset / np.linalg.norm(offset)
    if abs(along := axis @ direction) > ALONG_AXIS:
        direction = np.copysign(1.0, along) * axis
    is_along_axis = np.abs(direction).max() > ALIGNED
    return np.round(direction) + 0.0 if is_along_axis else direction
