"""Limits of joints, completed where a URDF leaves them out."""

import math
from dataclasses import replace

from aerodrake.model.vehicle.urdf_joints import SMALLEST
from aerodrake.mounting.arm import ArmJoint, ArmTree, Converted, Limits
from aerodrake.mounting.listed import listed, shown
from aerodrake.mounting.loads import Load, joint_loads

TURN_RAD = 2 * math.pi
"""Limit of a continuous joint, to both sides."""
HALF_TURN_RAD = math.pi
"""Limit of a revolute joint without limits, to both sides."""
VELOCITY_RAD_S = 3.0
"""Velocity limit of a joint without one."""
ACCELERATION_RAD_S2 = 15.0
"""Acceleration limit of a joint without one, unless its effort gives less."""
HOLDING = 2.0
"""Effort of a joint without one, as a multiple of the largest torque that holds it."""


def complete_limits(arm: ArmTree, tool: str) -> Converted:
    """Completes the limits of the joints that move the tool, and makes all of them revolute."""
    changes: dict[str, list[str]] = {}
    ranged: dict[str, ArmJoint] = {}
    for joint in arm.moving(tool):
        limits, change = _range(joint)
        ranged[joint.name] = replace(joint, kind="revolute", limits=limits)
        if change:
            changes.setdefault(change, []).append(joint.name)
    loads = joint_loads(arm, list(ranged.values()))
    complete: dict[str, ArmJoint] = {}
    for name, joint in ranged.items():
        limits = _rated(joint.limits, loads[name])
        complete[name] = replace(joint, limits=limits)
        for change in _rating_changes(joint.limits, limits):
            changes.setdefault(change, []).append(name)
    sentences = (f"{change}: {listed(names)}" for change, names in changes.items())
    return Converted(arm.with_joints(complete), tuple(sentences))


def _range(joint: ArmJoint) -> tuple[Limits, str]:
    """Returns the limits with a range of positions, and the change."""
    limits = joint.limits
    lower, upper = limits.lower, limits.upper
    most = TURN_RAD if joint.kind == "continuous" else HALF_TURN_RAD
    if lower is None or upper is None or upper - lower == 0:
        if lower is None and upper is not None:
            lower = min(-most, upper - most)
        elif upper is None and lower is not None:
            upper = max(most, lower + most)
        else:
            lower, upper = -most, most
        kind = "continuous joints" if joint.kind == "continuous" else "joints without limits"
        change = f"{kind} get the limits {shown(lower)} and {shown(upper)} rad"
    elif upper < lower:
        lower, upper = upper, lower
        change = "lower limits above the upper ones are swapped with them"
    else:
        return limits, ""
    return replace(limits, lower=lower, upper=upper), change


def _rated(limits: Limits, load: Load) -> Limits:
    """Returns the limits with those of effort, velocity and acceleration."""
    effort, velocity, acceleration = limits.effort, limits.velocity, limits.acceleration
    if not _is_given(effort):
        effort = _rounded(HOLDING * load.torque + ACCELERATION_RAD_S2 * load.inertia)
    if not _is_given(velocity):
        velocity = VELOCITY_RAD_S
    if not _is_given(acceleration):
        acceleration = min(ACCELERATION_RAD_S2, _rounded(effort / load.inertia))
    return replace(limits, effort=effort, velocity=velocity, acceleration=acceleration)


def _is_given(limit: float | None) -> bool:
    return limit is not None and limit > SMALLEST


def _rounded(number: float) -> float:
    """Returns a number with three significant digits."""
    return float(f"{number:.3g}")


def _rating_changes(old: Limits, new: Limits) -> list[str]:
    """Returns a description of each limit that was completed."""
    changes = []
    if old.effort != new.effort:
        law = f"{HOLDING:g} times the torque that holds the links below, and their acceleration"
        changes.append(f"no effort limit given, set to {shown(new.effort)} N m ({law})")
    if old.velocity != new.velocity:
        changes.append(f"no velocity limit given, set to {shown(new.velocity)} rad/s")
    if old.acceleration != new.acceleration:
        least = "" if new.acceleration == ACCELERATION_RAD_S2 else " (effort over inertia)"
        limit = f"{shown(new.acceleration)} rad/s^2{least}"
        changes.append(f"no acceleration limit given, set to {limit}")
    return changes
