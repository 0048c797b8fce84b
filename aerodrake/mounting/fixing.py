"""Joints that do not move the tool of a serial arm, fixed at a position."""

from collections.abc import Collection

from aerodrake.model.vehicle.urdf_joints import SMALLEST
from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.joint import ArmJoint
from aerodrake.mounting.listed import listed, shown
from aerodrake.support.errors import BadInput

FREE = ("floating", "planar")
"""Types of joints that are not supported below the root."""


def fix_joints(arm: ArmTree, tool: str) -> Converted:
    """Fixes all joints but the revolute ones between root and tool.

    Joints with a `<mimic>` are fixed where they follow the fixed ones. Others are fixed at zero,
    or at the limit next to it.

    Raises:
        BadInput: if a joint is floating or planar, or no revolute joint moves the tool.
    """
    names = {joint.name: joint for joint in arm.joints}
    on_path = [joint.name for joint in arm.path(tool)]
    fixed: dict[str, ArmJoint] = {}
    groups: dict[tuple[str, str], list[str]] = {}
    for joint in arm.joints:
        if joint.kind in FREE:
            problem = f"expected revolute, prismatic or fixed joints, got type {joint.kind}"
            raise BadInput("", f"joint {joint.name}", problem)
        reason = _reason(joint, on_path)
        if joint.kind == "fixed" or not reason:
            continue
        position = rest(joint, names)
        fixed[joint.name] = joint.at(position)
        unit = "rad" if joint.is_moving else "m"
        groups.setdefault((reason, f"{shown(position)} {unit}"), []).append(joint.name)
    arm = arm.with_joints(fixed)
    if not arm.moving(tool):
        problem = f"expected revolute joints between '{arm.root}' and '{tool}', got none"
        raise BadInput("tool", "", problem)
    return Converted(
        arm,
        tuple(
            f"{reason} fixed at {position}: {listed(joints)}"
            for (reason, position), joints in groups.items()
        ),
    )


def _reason(joint: ArmJoint, on_path: Collection[str]) -> str:
    """Returns a description of a joint that has to be fixed; empty for one that stays."""
    if joint.mimic is not None:
        return "joints that mimic another are"
    if not joint.is_moving:
        return "prismatic joints are"
    if joint.name not in on_path:
        return "joints that do not move the tool are"
    return "joints without room between their limits are" if not has_room(joint) else ""


def has_room(joint: ArmJoint) -> bool:
    """Returns True unless a joint's limits are equal on purpose.

    Programs that export a URDF write zeros for all limits that were not filled in.
    """
    limits = joint.limits
    if limits.lower is None or limits.upper is None:
        return True
    is_empty = limits.lower == 0 and not (limits.effort and limits.velocity)
    return abs(limits.upper - limits.lower) >= SMALLEST or is_empty


def rest(joint: ArmJoint, joints: dict[str, ArmJoint], depth: int = 0) -> float:
    """Returns the position at which a joint is fixed.

    Args:
        joint: The joint.
        joints: All joints by name, for those that it mimics.
        depth: Number of joints that mimic it, directly or not.
    """
    mimic = joint.mimic
    if mimic is not None and mimic.joint in joints and depth < len(joints):
        return mimic.multiplier * rest(joints[mimic.joint], joints, depth + 1) + mimic.offset
    lower, upper = joint.limits.lower, joint.limits.upper
    if joint.kind == "continuous" or (lower is not None and upper is not None and lower > upper):
        return 0.0
    return max(min(0.0, 0.0 if upper is None else upper), 0.0 if lower is None else lower)
