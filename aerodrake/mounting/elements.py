"""XML elements of a converted arm, for the URDF of a vehicle."""

from collections.abc import Iterable
from xml.dom.minidom import Document, Element

from aerodrake.model.vehicle.urdf_numbers import MOMENTS
from aerodrake.mounting.arm import ArmTree
from aerodrake.mounting.joint import ArmJoint, Limits
from aerodrake.mounting.link import ArmLink, Geometry
from aerodrake.mounting.pose import Pose
from aerodrake.mounting.shapes import ATTRIBUTES

XML = Document()
"""Document that makes the elements; none is part of it."""
LIMITS = {"acceleration": "drake:acceleration"}
"""Attributes of `<limit>` whose names differ from those of `Limits`."""


def arm_elements(arm: ArmTree, tool: str) -> list[Element]:
    """Returns the links, the joints, and a transmission for each joint that moves the tool."""
    motors = [_transmission(joint) for joint in arm.moving(tool)]
    return [*map(_link, arm.links), *map(joint_element, arm.joints), *motors]


def filter_element(links: Iterable[str], name: str = "robot") -> Element:
    """Returns a collision filter group, whose links do not collide with each other."""
    members = [element("drake:member", link=link) for link in links]
    ignored = element("drake:ignored_collision_filter_group", name=name)
    return element("drake:collision_filter_group", *members, ignored, name=name)


def element(tag: str, *inner: Element | str, **attributes: str) -> Element:
    """Returns an element with attributes, children and text."""
    made = XML.createElement(tag)
    for name, value in attributes.items():
        made.setAttribute(name, value)
    for node in inner:
        made.appendChild(XML.createTextNode(node) if isinstance(node, str) else node)
    return made


def decimals(numbers: Iterable[float]) -> str:
    """Returns numbers with at most twelve significant digits."""
    return " ".join(f"{number + 0.0:.12g}" for number in numbers)  # The sum has no -0.


def joint_element(joint: ArmJoint) -> Element:
    """Returns a joint with its limits."""
    inner = [
        element("parent", link=joint.parent),
        element("child", link=joint.child),
        _origin(joint.origin),
    ]
    if joint.is_moving:
        inner += [element("axis", xyz=decimals(joint.axis)), _limit(joint.limits)]
        if joint.damping or joint.friction:
            damping, friction = decimals([joint.damping]), decimals([joint.friction])
            inner.append(element("dynamics", damping=damping, friction=friction))
    return element("joint", *inner, name=joint.name, type=joint.kind)


def _limit(limits: Limits) -> Element:
    values = {LIMITS.get(name, name): value for name, value in vars(limits).items()}
    return element("limit", **{name: decimals([value]) for name, value in values.items()})


def _origin(pose: Pose) -> Element:
    return element("origin", xyz=decimals(pose.xyz), rpy=decimals(pose.rpy))


def _link(link: ArmLink) -> Element:
    inner = []
    if (inertial := link.inertial) is not None:
        moments = dict(zip(MOMENTS, inertial.moments, strict=True))
        # All digits, since rounded moments of a flat body can be those of none.
        inertia = {name: repr(moment + 0.0) for name, moment in moments.items()}
        mass = element("mass", value=decimals([inertial.mass]))
        inner.append(
            element("inertial", _origin(inertial.origin), mass, element("inertia", **inertia))
        )
    inner += [_geometry("visual", geometry) for geometry in link.visuals]
    inner += [_geometry("collision", geometry) for geometry in link.collisions]
    return element("link", *inner, name=link.name)


def _geometry(role: str, geometry: Geometry) -> Element:
    shape, start = element(geometry.shape), 0
    if geometry.file is not None:
        shape.setAttribute("filename", geometry.file.as_posix())
    for name, count in ATTRIBUTES[geometry.shape]:
        shape.setAttribute(name, decimals(geometry.numbers[start : start + count]))
        start += count
    inner = [_origin(geometry.origin), element("geometry", shape)]
    if geometry.rgba is not None and role == "visual":
        name = f"rgba {decimals(geometry.rgba)}"
        inner.append(element("material", element("color", rgba=decimals(geometry.rgba)), name=name))
    return element(role, *inner)


def _transmission(joint: ArmJoint) -> Element:
    actuator = element("actuator", name=f"{joint.name}_motor")
    if (motor := joint.motor) is not None:
        actuator.appendChild(element("drake:gear_ratio", value=decimals([motor.gear_ratio])))
        inertia = element("drake:rotor_inertia", value=decimals([motor.rotor_inertia]))
        actuator.appendChild(inertia)
    kind = element("type", "SimpleTransmission")
    return element("transmission", kind, element("joint", name=joint.name), actuator)
