"""Part of a robot that is mounted: the tree below one link, which contains the tool."""

import math

from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.joint import MOVING
from aerodrake.mounting.listed import listed, shown
from aerodrake.support.errors import BadInput, nearest


def select_tree(arm: ArmTree, tool: str, root: str = "") -> Converted:
    """Keeps the tree that contains the tool, without the links of the world above it.

    A link of the world has neither mass nor geometry, and one joint, which does not move the arm.

    Args:
        arm: The robot.
        tool: Name of the link of the tool.
        root: Name of the link that is mounted on the base; empty for the root of the tree.

    Raises:
        BadInput: if there is no link of a name, or the tool is not below the root.
    """
    names = [link.name for link in arm.links]
    for argument, name in (("tool", tool), ("root", root)):
        if name not in (*names, ""):
            raise BadInput(argument, "", f"expected a link, got '{name}'; {nearest(name, names)}")
    path = arm.path(tool)
    above = [path[0].parent, *(joint.child for joint in path)] if path else [tool]
    if root and root not in above[:-1]:
        problem = f"expected a link above '{tool}', got '{root}'; {nearest(root, above[:-1])}"
        raise BadInput("root", "", problem)
    kept = set(arm.below(root or above[0]))
    removed = [link.name for link in arm.links if link.name not in kept]
    arm, changes = arm.without(set(removed)), []
    if removed:
        tree = f"the tree below '{root or above[0]}'"
        changes.append(f"links outside {tree} are removed: {listed(removed)}")
    while not root and (sentence := _world(arm, tool)):
        changes.append(sentence)
        arm = arm.without({arm.root})
    return Converted(arm, tuple(changes))


def _world(arm: ArmTree, tool: str) -> str:
    """Returns a sentence about the root if it is a link of the world; else empty."""
    link = arm.link(arm.root)
    joints = [joint for joint in arm.joints if joint.parent == link.name]
    is_part = link.mass or link.visuals or link.collisions or link.name == tool
    if is_part or len(joints) != 1 or joints[0].kind in (*MOVING, "prismatic"):
        return ""
    offset = math.hypot(*joints[0].origin.xyz)
    away = f", {shown(offset)} m away from it" if offset else ""
    return f"link '{link.name}' is removed; the arm begins with '{joints[0].child}'{away}"
