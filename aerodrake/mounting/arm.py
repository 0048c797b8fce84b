"""Arms as typed trees of links and joints, between their URDF and that of a vehicle."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

MOVING = ("revolute", "continuous")
"""Types of the joints that can be part of an arm."""


class Pose(NamedTuple):
    """Pose of a frame in another, as in an `<origin>`.

    Attributes:
        xyz: m, position.
        rpy: rad, roll, pitch and yaw.
    """

    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)

    @classmethod
    def of(cls, X: RigidTransform) -> Self:
        """Returns a transform as a pose."""
        rpy = RollPitchYaw(X.rotation()).vector()
        return cls(tuple(X.translation().tolist()), tuple(rpy.tolist()))

    def transform(self) -> RigidTransform:
        """Returns the pose as a transform."""
        return RigidTransform(RollPitchYaw(*self.rpy), np.array(self.xyz))


@dataclass(frozen=True)
class Inertial:
    """Mass of a link.

    Attributes:
        origin: Centre of mass and axes of the inertia, in the link's frame.
        mass: kg.
        moments: kg m^2, ixx, iyy, izz, ixy, ixz, iyz about the centre of mass.
    """

    origin: Pose
    mass: float
    moments: tuple[float, ...]


@dataclass(frozen=True)
class Geometry:
    """Visual or collision geometry of a link.

    Attributes:
        origin: Its pose in the link's frame.
        shape: Name of the shape in a URDF, a key of `shapes.ATTRIBUTES`.
        numbers: Numbers of the shape's attributes in order, m; scale factors of a mesh.
        file: File of a mesh.
        rgba: Colour; None for the mesh's own.
    """

    origin: Pose
    shape: str
    numbers: tuple[float, ...]
    file: Path | None = None
    rgba: tuple[float, ...] | None = None


@dataclass(frozen=True)
class ArmLink:
    """Link of an arm."""

    name: str
    inertial: Inertial | None = None
    visuals: tuple[Geometry, ...] = ()
    collisions: tuple[Geometry, ...] = ()

    @property
    def mass(self) -> float:
        """kg; zero without an `<inertial>`."""
        return self.inertial.mass if self.inertial else 0.0


@dataclass(frozen=True)
class Limits:
    """Limits of a joint; None for those that are not given.

    Attributes:
        lower, upper: rad, or m of a prismatic joint.
        effort: N m.
        velocity: rad/s.
        acceleration: rad/s^2.
    """

    lower: float | None = None
    upper: float | None = None
    effort: float | None = None
    velocity: float | None = None
    acceleration: float | None = None


@dataclass(frozen=True)
class Mimic:
    """Relation of a joint's position to another's: multiplier * position + offset.

    Attributes:
        joint: Name of the other joint.
        multiplier: Ratio of the positions.
        offset: rad, or m of a prismatic joint.
    """

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Motor:
    """Motor behind a gear.

    Attributes:
        gear_ratio: Ratio of the motor's rate to the joint's.
        rotor_inertia: kg m^2, before the gear.
    """

    gear_ratio: float = 1.0
    rotor_inertia: float = 0.0


@dataclass(frozen=True)
class ArmJoint:
    """Joint of an arm.

    Attributes:
        name: Its name.
        kind: Its type in the URDF.
        parent, child: Names of its links.
        origin: Pose of the child's frame in the parent's at zero.
        axis: Axis in the child's frame.
        limits: Its limits.
        damping: N m s/rad.
        friction: N m.
        mimic: The joint that it follows.
        motor: Its motor; None for one without inertia.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Pose = Pose()
    axis: tuple[float, ...] = (1.0, 0.0, 0.0)
    limits: Limits = Limits()
    damping: float = 0.0
    friction: float = 0.0
    mimic: Mimic | None = None
    motor: Motor | None = None

    @property
    def is_moving(self) -> bool:
        """True for a revolute joint."""
        return self.kind in MOVING

    def at(self, position: float) -> Self:
        """Returns the joint fixed at a position in rad, or m of a prismatic joint."""
        origin = self.origin
        if position:
            axis = np.array(self.axis) / math.hypot(*self.axis)
            moved = RigidTransform(position * axis)
            if self.is_moving:
                moved = RigidTransform(RotationMatrix(AngleAxis(position, axis)))
            origin = Pose.of(self.origin.transform() @ moved)
        return type(self)(self.name, "fixed", self.parent, self.child, origin)


@dataclass(frozen=True)
class ArmTree:
    """Links and joints of an arm, which form a tree.

    Attributes:
        name: Name of the robot.
        links, joints: Links and joints in the order of the file.
    """

    name: str
    links: tuple[ArmLink, ...]
    joints: tuple[ArmJoint, ...]

    @cached_property
    def above(self) -> dict[str, ArmJoint]:
        """The joint above each link but the roots."""
        return {joint.child: joint for joint in self.joints}

    @cached_property
    def _joints_of(self) -> dict[str, list[ArmJoint]]:
        """The joints below each link that has some."""
        joints: dict[str, list[ArmJoint]] = {}
        for joint in self.joints:
            joints.setdefault(joint.parent, []).append(joint)
        return joints

    @cached_property
    def roots(self) -> list[str]:
        """Names of the links without a joint above them."""
        return [link.name for link in self.links if link.name not in self.above]

    @property
    def root(self) -> str:
        """Name of the first link without a joint above it."""
        return self.roots[0]

    @property
    def mass(self) -> float:
        """kg, total mass."""
        return sum(link.mass for link in self.links)

    def link(self, name: str) -> ArmLink:
        """Returns the link of a name."""
        return next(link for link in self.links if link.name == name)

    def path(self, link: str) -> list[ArmJoint]:
        """Returns the joints from the link's root down to it."""
        joints = []
        while link in self.above:
            joints.append(self.above[link])
            link = joints[-1].parent
        return joints[::-1]

    def moving(self, tool: str) -> list[ArmJoint]:
        """Returns the joints that move a link, from the root."""
        return [joint for joint in self.path(tool) if joint.is_moving]

    def below(self, link: str) -> Iterator[str]:
        """Yields a link and all below it; parents come first."""
        waiting = [link]
        while waiting:
            yield (link := waiting.pop())
            waiting += [joint.child for joint in reversed(self._joints_of.get(link, ()))]

    def tips(self) -> list[str]:
        """Returns the links without a joint below them."""
        parents = {joint.parent for joint in self.joints}
        return [link.name for link in self.links if link.name not in parents]

    def reach(self, tool: str) -> float:
        """Returns the length in m of the chain from its first moving joint to the tool."""
        path = self.path(tool)
        first = next((i for i, joint in enumerate(path) if joint.is_moving), len(path))
        return sum(math.hypot(*joint.origin.xyz) for joint in path[first + 1 :])

    def poses(self, positions: dict[str, float] | None = None) -> dict[str, RigidTransform]:
        """Returns the poses of the links in their root, at positions of joints by name."""
        given, poses = positions or {}, {root: RigidTransform() for root in self.roots}
        links = [link for root in self.roots for link in self.below(root)]
        for joint in (self.above[link] for link in links if link in self.above):
            fixed = joint.at(given.get(joint.name, 0.0))
            poses[joint.child] = poses[joint.parent] @ fixed.origin.transform()
        return poses

    def with_links(self, links: dict[str, ArmLink]) -> Self:
        """Returns the arm with some links replaced, by name."""
        return replace(self, links=tuple(links.get(link.name, link) for link in self.links))

    def with_joints(self, joints: dict[str, ArmJoint]) -> Self:
        """Returns the arm with some joints replaced, by name."""
        return replace(self, joints=tuple(joints.get(joint.name, joint) for joint in self.joints))

    def without(self, links: set[str]) -> Self:
        """Returns the arm without some links and their joints."""
        joints = (j for j in self.joints if not {j.parent, j.child} & links)
        kept = (link for link in self.links if link.name not in links)
        return replace(self, links=tuple(kept), joints=tuple(joints))


class Converted(NamedTuple):
    """Result of a step of the conversion.

    Attributes:
        arm: The arm after the step.
        changes: One sentence for each change.
    """

    arm: ArmTree
    changes: tuple[str, ...] = ()
