"""Tool of an arm: the link at the end of its chain, and the direction it points in."""

import itertools
import re
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.collision import bounding_points
from aerodrake.mounting.joint import ArmJoint
from aerodrake.support.errors import BadInput, nearest

FINGER = re.compile(r"finger|jaw|claw|thumb|knuckle|index|pinky", re.IGNORECASE)
"""Names of parts of a gripper, and of joints that move them."""
GRIPPER = re.compile(
    rf"^(?!.*((?<!cont)roll|rot|wrist)).*(grip|hand|{FINGER.pattern})", re.IGNORECASE
)
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
            BadInput: if there is no such link, or no revolute joint above it; without the URDF's
                name, if it has no revolute joints.
        """
        names = [link.name for link in arm.links]
        if wanted and wanted not in names:
            problem = f"expected a link, got '{wanted}'; {nearest(wanted, names)}"
            raise BadInput("tool", "", problem)
        if not any(joint.is_moving for joint in arm.joints):
            raise BadInput("", "", "expected revolute joints, got none")
        link, reason = (wanted, "as given") if wanted else _guess(arm)
        if not arm.moving(link):
            problem = f"expected a link with revolute joints above it, got '{link}' without"
            raise BadInput("tool", "", problem)
        end = 2 * _centre(arm, link) if reason == LAST else np.zeros(3)
        direction = _direction(arm, link, end)
        return cls(link, max(0.0, end @ direction) * direction, direction, reason)


def _joints(path: Sequence[ArmJoint], fingers: Collection[str]) -> list[ArmJoint]:
    """Returns the moving joints of a path without those at its end that move a gripper.

    If there are no others, only joints that follow another one are left out.

    Args:
        path: The path.
        fingers: Names of joints of a hand.
    """
    moving = [joint for joint in path if joint.is_moving]
    is_own = [not (joint.name in fingers or _of_gripper(joint)) for joint in moving]
    count = max((i for i, own in enumerate(is_own, start=1) if own), default=0)
    return moving[:count] or [joint for joint in moving if joint.mimic is None]


def _fingers(arm: ArmTree) -> set[str]:
    """Returns the names of the joints of hands, whatever they are called.

    A hand is a link from which two or more chains of joints branch, each with fewer joints than the
    chain that leads to it.
    """
    deepest, branches = Counter[str](), Counter[str]()
    for link in reversed([link for root in arm.roots for link in arm.below(root)]):
        if (joint := arm.above.get(link)) is None:
            continue
        count = deepest[link] + (joint.kind != "fixed" and joint.mimic is None)
        deepest[joint.parent] = max(deepest[joint.parent], count)
        branches[joint.parent] += count > 0
    hands = [
        link
        for link, count in branches.items()
        if count > 1 and deepest[link] < len(arm.moving(link))
    ]
    return {arm.above[link].name for hand in hands for link in arm.below(hand) if link != hand}


def _after(path: Sequence[ArmJoint], own: Sequence[ArmJoint]) -> list[ArmJoint]:
    """Returns the joints of a path after the last one of the arm's own."""
    return [*itertools.takewhile(lambda joint: joint not in own[-1:], reversed(path))]


def _of_gripper(joint: ArmJoint) -> bool:
    """Returns True if a joint moves a part of a gripper."""
    named = GRIPPER.search(joint.name) or FINGER.search(joint.child)
    return joint.mimic is not None or bool(named)


def _guess(arm: ArmTree) -> tuple[str, str]:
    """Returns the link of the tool and the reason."""
    counts, fingers = {}, _fingers(arm)
    for link in arm.links:
        own = _joints(arm.path(link.name), fingers)
        beyond = [joint for joint in _after(arm.path(link.name), own) if joint.kind != "fixed"]
        counts[link.name] = 0 if beyond else len(own)
    most = max(counts.values())
    last = [name for name, count in counts.items() if count == most]
    tips = set(arm.tips())
    markers = [name for name in last if name in tips and _is_frame(arm, name)]
    for pattern in MARKERS:
        for name in markers:
            if pattern.search(name):
                return name, "the frame with this name after the last joint"
    if len(markers) == 1:
        return markers[0], "the only frame after the last joint"
    link = last[0]
    while len(below := [j.child for j in arm.joints if j.parent == link and j.child in last]) == 1:
        link = below[0]
    return link, LAST


def _is_frame(arm: ArmTree, name: str) -> bool:
    """Returns True if a link marks a frame: it has no mass, in arms without masses no geometry."""
    link = arm.link(name)
    return link.mass <= FRAME_KG and bool(arm.mass or not (link.visuals or link.collisions))


def _centre(arm: ArmTree, name: str) -> np.ndarray:
    """Returns the centre of mass (3,) m of a link, or that of its geometry, or its origin."""
    link = arm.link(name)
    if link.inertial:
        return np.array(link.inertial.origin.xyz)
    points = bounding_points(link)
    return (points.min(axis=0) + points.max(axis=0)) / 2 if len(points) else np.zeros(3)


def _direction(arm: ArmTree, link: str, end: np.ndarray) -> np.ndarray:
    """Returns the direction (3,) of a tool in its link's frame.

    It is the axis of the last joint, towards the tool, or if that is across the last link, as in
    planar arms, the direction from the last joint to the tool.

    Args:
        arm: The arm.
        link: Name of the tool's link.
        end: (3,) m, the tool in the link's frame; zero for a frame at the tool.
    """
    poses = arm.poses()
    joints = _joints(arm.path(link), _fingers(arm))[::-1]
    # From the origins of the joints to the tool, in the link's frame, all at zero.
    X_ET = poses[link].inverse()
    offsets = [end - X_ET.multiply(poses[joint.child].translation()) for joint in joints]
    axis = (X_ET @ poses[joints[0].child]).rotation() @ np.array(joints[0].axis)
    axis = axis / np.linalg.norm(axis)
    offset = next((d for d in offsets if np.linalg.norm(d) > SMALL_M), axis)
    direction = offset / np.linalg.norm(offset)
    if abs(axis @ direction) > ALONG_AXIS:
        along = axis @ direction
        if end.any() and len(offsets) > 1 and abs(axis @ offsets[1]) > SMALL_M:
            along = axis @ offsets[1]  # The centre of mass of a short link can be behind its joint.
        direction = np.copysign(1.0, along) * axis
    is_along_axis = np.abs(direction).max() > ALIGNED
    return np.round(direction) + 0.0 if is_along_axis else direction
