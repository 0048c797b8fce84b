"""Arms as typed trees of links and joints, between their URDF and that of a vehicle."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, Self

from pydrake.math import RigidTransform

from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.link import ArmLink


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
