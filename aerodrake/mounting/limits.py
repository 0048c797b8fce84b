"""Limits of joints, completed where a URDF leaves them out."""

import math
from dataclasses import replace

from aerodrake.model.vehicle.urdf_joints import SMALLEST
from aerodrake.model.vehicle.urdf_numbers import LARGEST
from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.joint import ArmJoint, Limits
from aerodrake.mounting.listed import listed, shown
from aerodrake.mounting.loads import Load, joint_loads

TURN_RAD = 2 * math.pi
"""Limit of a continuous joint, to both sides."""
HALF_TURN_RAD = math.pi
"""Limit of a revolute joint without limits, to both sides."""
MANY_RAD = 40.0
"""Position limit above which it could be meant in degrees."""
VELOCITY_RAD_S = 3.0
"""Velocity limit of a joint without one."""
ACCELERATION_RAD_S2 = 15.0
"""Acceleration limit of a joint without one, unless its effort gives less."""
LEAST_RAD_S2 = 0.1
"""Smallest acceleration limit of a joint without one."""
HOLDING = 2.0
"""Effort of a joint without one, as a multiple of the largest torque that holds it."""
LEAST_EFFORT_SHARE = 0.02
"""Smallest effort of a joint without one, as a share of the arm's largest."""

LAWS = {
    "effort": f"{HOLDING:g} times the largest torque that holds the links below, plus the torque "
    f"of {ACCELERATION_RAD_S2:g} rad/s^2, in N m, or {LEAST_EFFORT_SHARE:.0%} of the arm's largest",
    "velocity": f"{VELOCITY_RAD_S:g} rad/s",
    "acceleration": f"{ACCELERATION_RAD_S2:g} rad/s^2, or effort over the largest inertia",
}
"""Laws of limits that are missing."""


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
    efforts = [_effort(joint.limits, loads[name]) for name, joint in ranged.items()]
    least_effort = LEAST_EFFORT_SHARE * max(efforts)
    complete = {
        name: replace(joint, limits=_rated(joint.limits, loads[name], least_effort))
        for name, joint in ranged.items()
    }
    for name, law in LAWS.items():
        values: dict[str, list[str]] = {}
        for joint in complete.values():
            if (value := getattr(joint.limits, name)) != getattr(ranged[joint.name].limits, name):
                values.setdefault(shown(value), []).append(joint.name)
        if values:
            texts = [f"{value} ({', '.join(joints)})" for value, joints in values.items()]
            changes[f"missing {name} limits are set to {law}"] = texts
    sentences = (f"{change}: {listed(names)}" for change, names in changes.items())
    return Converted(arm.with_joints(complete), tuple(sentences))


def _range(joint: ArmJoint) -> tuple[Limits, str]:
    """Returns the limits with a range of positions, and the change."""
    limits = joint.limits
    lower, upper = limits.lower, limits.upper
    most = TURN_RAD if joint.kind == "continuous" else HALF_TURN_RAD
    if lower is None or upper is None or abs(upper - lower) < SMALLEST:
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
    elif max(abs(lower), abs(upper)) > MANY_RAD:
        return limits, f"limits above {MANY_RAD:g} rad are kept, and could be degrees"
    else:
        return limits, ""
    return replace(limits, lower=lower, upper=upper), change


def _effort(limits: Limits, load: Load) -> float:
    """Returns the effort limit, or the one that the load of its joint needs."""
    if _is_given(limits.effort):
        return limits.effort
    return min(HOLDING * load.torque + ACCELERATION_RAD_S2 * load.inertia, LARGEST)


def _rated(limits: Limits, load: Load, least_effort: float) -> Limits:
    """Returns the limits with those of effort, velocity and acceleration."""
    effort, velocity, acceleration = limits.effort, limits.velocity, limits.acceleration
    if not _is_given(effort):
        effort = _rounded(max(_effort(limits, load), least_effort))
    if not _is_given(velocity):
        velocity = VELOCITY_RAD_S
    if not _is_given(acceleration):
        attained = max(LEAST_RAD_S2, _rounded(effort / load.inertia))
        acceleration = min(ACCELERATION_RAD_S2, attained)
    return replace(limits, effort=effort, velocity=velocity, acceleration=acceleration)


def _is_given(limit: float | None) -> bool:
    return limit is not None and limit > SMALLEST


def _rounded(number: float) -> float:
    """Returns a number with three significant digits."""
    return float(f"{number:.3g}")
