"""Joints of a URDF: a serial arm of revolute joints, with limits and transmissions."""

from collections import Counter
from collections.abc import Collection, Sequence
from xml.dom.minidom import Element

import numpy as np

from aerodrake.model.vehicle.urdf_links import only_child
from aerodrake.model.vehicle.urdf_numbers import NUMBERS
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.urdf_element import attribute, child, children, fault, numbers, text

REVOLUTE = ("revolute", "continuous")
"""Types of the arm's joints. Drake treats both alike."""
LIMITS = {name: limit.unit for name, limit in NUMBERS["joint/limit"].items()}
"""Limits of a joint and their units."""
SMALLEST = 1e-8
"""Smallest limit, range of a joint, and norm of its axis, which is Drake's."""
UNSUPPORTED = (
    "drake:joint",
    "drake:linear_bushing_rpy",
    "drake:linear_spring_damper",
    "drake:ball_constraint",
    "drake:distance_constraint",
    "drake:tendon_constraint",
    "loop_joint",
)
"""Elements that would connect links in other ways than by joints of the arm."""


def check_joints(robot: Element, base: str, tool: str) -> None:
    """Checks the joints and transmissions of a URDF whose links have been checked.

    Args:
        robot: The root element.
        base: Name of the link of the base.
        tool: Name of the frame or link of the tool.

    Raises:
        BadInput: if the links are not a tree from the base; if the joints from base to tool are
            not revolute or fixed, or lack an axis, limits or a transmission; if another joint
            moves; if the transmissions are not in the order of the joints.
    """
    for element in children(robot):
        if element.tagName in UNSUPPORTED:
            raise fault(element, f"expected joints of the arm alone, got <{element.tagName}>")
    links = dict.fromkeys(link.getAttribute("name") for link in children(robot, "link"))
    frames = {f.getAttribute("name"): f.getAttribute("link") for f in children(robot, "frame")}
    tool_link = frames.get(tool, tool)
    if tool_link not in links:
        raise BadInput("", "", f"expected a frame named '{tool}', whose origin is the end-effector")
    parents = _parents(robot, links, base)
    path: list[Element] = []
    while tool_link != base:
        path.append(parents[tool_link])
        tool_link = attribute(path[-1], "parent", "link")
    arm = [joint for joint in reversed(path) if joint.getAttribute("type") in REVOLUTE]
    names = [joint.getAttribute("name") for joint in arm]
    if not arm:
        raise BadInput("", "", f"expected revolute joints between '{base}' and '{tool}', got none")
    in_series = set(names)
    for name, joint in ((joint.getAttribute("name"), joint) for joint in parents.values()):
        if joint.getAttribute("type") in REVOLUTE and name not in in_series:
            raise fault(
                joint,
                f"expected all moving joints in series between '{base}' and '{tool}', got a branch "
                f"beside {', '.join(names)}; make it fixed, or correct its <parent>",
            )
    for joint in arm:
        _check_limits(joint)
    _check_transmissions(robot, names)


def _parents(robot: Element, links: Collection[str], base: str) -> dict[str, Element]:
    """Returns the joint above each link but the base, after checking that they form a tree."""
    above: dict[str, Element] = {}
    for joint in children(robot, "joint"):
        kind = joint.getAttribute("type")
        if kind not in (*REVOLUTE, "fixed"):
            raise fault(joint, f"expected type revolute, continuous or fixed, got '{kind}'")
        if only_child(joint, "mimic") is not None:
            raise fault(joint, "expected no <mimic>, since all joints are independent")
        for end in ("parent", "child"):
            if (link := attribute(joint, end, "link")) not in links:
                names = nearest(link, links)
                raise fault(joint, f"<{end} link>: expected a link, got '{link}'; {names}")
        link = attribute(joint, "child", "link")
        if link == base:
            problem = f"expected '{base}' to be free, without a joint above it, got it as the child"
            raise fault(joint, problem)
        if link in above:
            other = above[link].getAttribute("name")
            raise fault(joint, f"expected one joint above '{link}', which is below {other}, too")
        above[link] = joint
    connected = {base}
    for first in links:
        link, seen = first, {first}
        while link not in connected:
            if link not in above:
                problem = f"expected joints that connect it to '{base}', got none above '{link}'"
                raise BadInput("", f"link {first}", problem)
            link = attribute(above[link], "parent", "link")
            if link in seen:
                raise fault(above[link], f"expected no loop of joints, got one through '{link}'")
            seen.add(link)
        connected |= seen
    return above


def _check_limits(joint: Element) -> None:
    """Raises BadInput unless a revolute joint has an axis, all limits, and room to move."""
    for tag in ("origin", "axis", "dynamics"):
        only_child(joint, tag)
    axis = child(joint, "axis")
    if np.linalg.norm(numbers(axis, "xyz", "1 0 0")) < SMALLEST:
        got = attribute(joint, "axis", "xyz")
        raise fault(joint, f"<axis xyz>: expected a vector other than zero, got '{got}'")
    limit = only_child(joint, "limit")
    given = {name for name in LIMITS if limit is not None and limit.hasAttribute(name)}
    if absent := [name for name in LIMITS if name not in given]:
        units = ", ".join(f"{name} in {LIMITS[name]}" for name in absent)
        raise fault(joint, f"<limit>: missing {', '.join(absent)}; expected {units}")
    values = {name: float(limit.getAttribute(name)) for name in LIMITS}
    if values["upper"] - values["lower"] < SMALLEST:
        lower, upper = limit.getAttribute("lower"), limit.getAttribute("upper")
        problem = f"<limit>: expected lower below upper, got lower='{lower}' upper='{upper}'"
        raise fault(joint, problem)
    for name in ("effort", "velocity", "drake:acceleration"):
        if values[name] < SMALLEST:
            got = limit.getAttribute(name)
            problem = f"expected a positive number in {LIMITS[name]}, got '{got}'"
            raise fault(joint, f"<limit {name}>: {problem}")


def _check_transmissions(robot: Element, arm: Sequence[str]) -> None:
    """Raises BadInput unless the arm's joints have one transmission each, in their order."""
    joints = {joint.getAttribute("name") for joint in children(robot, "joint")}
    driven, moving = [], set(arm)
    for element in children(robot, "transmission"):
        joint = only_child(element, "joint")
        name = joint.getAttribute("name") if joint is not None else ""
        if name not in joints:
            raise fault(
                element, f"<joint name>: expected a joint, got '{name}'; {nearest(name, joints)}"
            )
        kind = child(element, "type")
        kind = text(kind) if kind is not None else element.getAttribute("type")
        if "SimpleTransmission" not in kind:
            raise fault(element, f"<type>: expected SimpleTransmission, got '{kind}'")
        if not attribute(element, "actuator", "name"):
            raise fault(element, "expected one <actuator> with the attribute 'name'")
        only_child(element, "actuator")
        if name in moving:
            driven.append(name)
    counts = Counter(driven)
    for name in arm:
        if (count := counts[name]) != 1:
            raise BadInput(
                "", f"joint {name}", f"expected one <transmission>, got {count or 'none'}"
            )
    if driven != list(arm):
        raise BadInput(
            "",
            "",
            f"expected the transmissions in the order of the joints, {', '.join(arm)}, got "
            f"{', '.join(driven)}",
        )
    actuators = [attribute(e, "actuator", "name") for e in children(robot, "transmission")]
    for name, count in Counter(actuators).items():
        if count > 1:
            raise BadInput("", "", f"expected different names of actuators, got '{name}' twice")
