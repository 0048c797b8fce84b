"""Reading of an arm's URDF, as other programs export it."""

from collections import Counter
from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from xml.dom.minidom import Element

from aerodrake.model.vehicle.urdf_links import only_child
from aerodrake.model.vehicle.urdf_numbers import MOMENTS
from aerodrake.mounting.arm import ArmTree, Converted
from aerodrake.mounting.attributes import (
    read_limit,
    read_magnitude,
    read_numbers,
    read_pose,
    refuse_macros,
)
from aerodrake.mounting.joint import ArmJoint, Limits, Mimic, Motor
from aerodrake.mounting.link import ArmLink, Inertial
from aerodrake.mounting.listed import listed
from aerodrake.mounting.packages import find_mesh
from aerodrake.mounting.pose import Pose
from aerodrake.mounting.shapes import ShapeReader
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.urdf import read_document
from aerodrake.support.urdf_element import attribute, child, children, fault

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
"""Types of joints in a URDF."""
READ = {
    "robot": {"link", "joint", "frame", "material", "transmission"},
    "link": {"inertial", "visual", "collision"},
    "joint": {"origin", "parent", "child", "axis", "limit", "dynamics", "mimic"},
}
"""Elements that are read, by their parent."""
WORLD = "world"
"""Link that a joint may have as its parent without an element, as in Drake."""
REFUSED = ("drake:joint", "loop_joint")
"""Elements that would connect links in other ways than the joints of a URDF."""


def read_arm(path: Path, packages: Sequence[Path] = ()) -> Converted:
    """Reads the URDF of an arm.

    Args:
        path: The URDF.
        packages: Folders of ROS packages, or folders that contain them, for `package://` URIs;
            the folders above the URDF are searched as well.

    Returns:
        The arm, and sentences about the elements and meshes that were left out.

    Raises:
        BadInput: if the file cannot be read or has macros; if a name, number or joint is invalid;
            if the links do not form a tree.
    """
    robot = read_document(path).documentElement
    try:
        shapes = ShapeReader(partial(find_mesh, folder=path.parent, packages=tuple(packages)))
        for element in children(robot):
            if element.tagName in REFUSED:
                raise fault(element, f"expected joints of a URDF alone, got <{element.tagName}>")
            if element.tagName in READ["robot"]:
                refuse_macros(element)
        for material in robot.getElementsByTagName("material"):
            shapes.define(material)
        motors = dict(_motors(robot))
        links = [_read_link(link, shapes) for link in children(robot, "link")]
        joints = [_read_joint(joint, motors) for joint in children(robot, "joint")]
        for frame in children(robot, "frame"):
            links.append(ArmLink(frame.getAttribute("name")))
            joints.append(_frame_joint(frame))
        if WORLD not in (part.name for part in links) and WORLD in (j.parent for j in joints):
            links.insert(0, ArmLink(WORLD))
        arm = ArmTree(robot.getAttribute("name") or path.stem, tuple(links), tuple(joints))
        check_tree(arm)
    except BadInput as error:
        raise BadInput(path, *error.args[1:]) from None
    return Converted(arm, tuple(_omissions(robot, shapes)))


def check_tree(arm: ArmTree) -> None:
    """Raises BadInput unless names are unique, and each link has at most one joint above it."""
    for noun, parts in (("links", arm.links), ("joints", arm.joints)):
        for name, count in Counter(part.name for part in parts).items():
            if not name:
                raise BadInput("", "", f"expected names of all {noun}, got one without")
            if count > 1:
                problem = f"expected different names of {noun}, got '{name}' {count} times"
                raise BadInput("", "", problem)
    links = [link.name for link in arm.links]
    if not links:
        raise BadInput("", "", "expected links, got none")
    joints_above = Counter(joint.child for joint in arm.joints)
    for joint in arm.joints:
        for end, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                problem = f"<{end} link>: expected a link, got '{link}'; {nearest(link, links)}"
                raise BadInput("", f"joint {joint.name}", problem)
        if (count := joints_above[joint.child]) > 1:
            problem = f"expected one joint above '{joint.child}', got {count}"
            raise BadInput("", f"joint {joint.name}", problem)
    for first in links:
        link, seen = first, {first}
        while link in arm.above:
            link = arm.above[link].parent
            if link in seen:
                joint = arm.above[link].name
                raise BadInput("", f"joint {joint}", f"expected no loop of joints, got '{link}'")
            seen.add(link)


def _read_link(link: Element, shapes: ShapeReader) -> ArmLink:
    inertial = only_child(link, "inertial")
    visuals, collisions = (shapes.read(link, role) for role in ("visual", "collision"))
    mass = None if inertial is None else _read_inertial(inertial)
    return ArmLink(link.getAttribute("name"), mass, visuals, collisions)


def _read_inertial(inertial: Element) -> Inertial:
    mass, inertia = child(inertial, "mass"), child(inertial, "inertia")
    moments = (read_numbers(inertia, name, 1, (0.0,))[0] for name in MOMENTS)
    return Inertial(read_pose(inertial), read_magnitude(mass, "value", "kg"), tuple(moments))


def _read_joint(joint: Element, motors: dict[str, Motor]) -> ArmJoint:
    name, kind = joint.getAttribute("name"), joint.getAttribute("type")
    if kind not in KINDS:
        raise fault(joint, f"expected a type of {', '.join(KINDS)}, got '{kind}'")
    limit, dynamics = child(joint, "limit"), child(joint, "dynamics")
    lower, upper, effort, velocity, acceleration = (
        read_limit(limit, key)
        for key in ("lower", "upper", "effort", "velocity", "drake:acceleration")
    )
    axis = read_numbers(child(joint, "axis"), "xyz", 3, (1.0, 0.0, 0.0))
    if kind not in ("fixed", "floating") and not any(axis):
        raise fault(joint, "<axis xyz>: expected a vector other than zero")
    return ArmJoint(
        name=name,
        kind=kind,
        parent=attribute(joint, "parent", "link"),
        child=attribute(joint, "child", "link"),
        origin=read_pose(joint),
        axis=axis,
        limits=Limits(lower, upper, effort, velocity, acceleration),
        damping=read_magnitude(dynamics, "damping", "N m s/rad"),
        friction=read_magnitude(dynamics, "friction", "N m"),
        mimic=_read_mimic(joint),
        motor=motors.get(name),
    )


def _read_mimic(joint: Element) -> Mimic | None:
    if (mimic := child(joint, "mimic")) is None:
        return None
    (multiplier,) = read_numbers(mimic, "multiplier", 1, (1.0,))
    (offset,) = read_numbers(mimic, "offset", 1, (0.0,))
    return Mimic(mimic.getAttribute("joint"), multiplier, offset)


def _motors(robot: Element) -> Iterable[tuple[str, Motor]]:
    """Yields the motors of the transmissions that have Drake's elements, by joint."""
    for transmission in children(robot, "transmission"):
        if (actuator := child(transmission, "actuator")) is None:
            continue
        ratio, inertia = (
            child(actuator, f"drake:{name}") for name in ("gear_ratio", "rotor_inertia")
        )
        if ratio is not None or inertia is not None:
            (gear,) = read_numbers(ratio, "value", 1, (1.0,))
            if not gear:
                raise fault(ratio, f"<{ratio.tagName} value>: expected a number other than zero")
            motor = Motor(gear, read_magnitude(inertia, "value", "kg m^2"))
            yield attribute(transmission, "joint", "name"), motor


def _frame_joint(frame: Element) -> ArmJoint:
    """Returns the fixed joint that holds a frame, which becomes a link without mass."""
    name = frame.getAttribute("name")
    pose = Pose(*(read_numbers(frame, key, 3, (0.0, 0.0, 0.0)) for key in ("xyz", "rpy")))
    return ArmJoint(f"{name}_frame", "fixed", frame.getAttribute("link"), name, pose)


def _omissions(robot: Element, shapes: ShapeReader) -> Iterable[str]:
    """Yields sentences about the elements and meshes that were left out."""
    unused = Counter(
        element.tagName
        for parent in (robot, *children(robot, "link"), *children(robot, "joint"))
        for element in children(parent)
        if element.tagName not in READ[parent.tagName]
    )
    if unused:
        names = ", ".join(f"<{tag}> ({count})" for tag, count in sorted(unused.items()))
        yield f"elements without a use in flight are removed: {names}"
    if shapes.missing:
        yield f"meshes without a file are left out: {listed(shapes.missing)}"
    if shapes.unreadable:
        yield f"geometry without a usable shape is left out: {listed(shapes.unreadable)}"
