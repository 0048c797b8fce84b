"""Links and frames of a URDF: their names, masses, inertias and geometry."""

from collections import Counter
from pathlib import Path
from xml.dom.minidom import Element

from pydrake.multibody.tree import RotationalInertia

from aerodrake.model.vehicle.urdf_numbers import MOMENTS, SHAPES
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.urdf_element import attribute, children, fault

COLLISION_MESHES = (".obj", ".vtk", ".gltf")
"""Endings of the meshes whose convex hull Drake can compute."""
FRICTION = ("static", "dynamic")
"""Kinds of a coefficient of friction."""

MARKER_KG = 1e-6
"""Largest mass of a link without inertia, as CAD programs export frames."""
ROUNDING = 1e-12
"""Largest ratio of principal moments of which the smaller one is zero up to rounding."""


def check_links(robot: Element, base: str) -> None:
    """Checks the links and frames of a URDF whose numbers have been checked.

    Args:
        robot: The root element.
        base: Name of the link of the base.

    Raises:
        BadInput: if a name is missing or not unique; if the inertia of a link is not physical; if
            geometry has no shape, or a shape that cannot collide; if a frame or a member of a
            collision filter group has no link.
    """
    for tags in (("link", "frame"), ("joint",)):
        _check_names(robot, tags)
    links = {link.getAttribute("name"): link for link in children(robot, "link")}
    if base not in links:
        advice = "for an arm without a vehicle use `aerodrake mount`"
        raise BadInput("", "", f"expected a link named '{base}'; {nearest(base, links)}; {advice}")
    for link in links.values():
        if (inertial := only_child(link, "inertial")) is not None:
            _check_inertia(inertial)
        for role in ("visual", "collision"):
            for element in children(link, role):
                _check_geometry(element)
    for frame in children(robot, "frame"):
        if (link := frame.getAttribute("link")) not in links:
            raise fault(frame, f"expected the name of a link, got '{link}'; {nearest(link, links)}")
    for group in children(robot, "drake:collision_filter_group"):
        for member in children(group, "drake:member"):
            if (link := member.getAttribute("link")) not in links:
                problem = f"<drake:member link>: expected a link, got '{link}'"
                raise BadInput("", "", f"{problem}; {nearest(link, links)}")


def only_child(element: Element, tag: str) -> Element | None:
    """Returns the child with a tag, if there is one.

    Raises:
        BadInput: if there are several, since Drake ignores all but the first.
    """
    if len(same := list(children(element, tag))) > 1:
        raise fault(element, f"expected one <{tag}>, got {len(same)}")
    return same[0] if same else None


def _check_names(robot: Element, tags: tuple[str, ...]) -> None:
    """Raises BadInput unless elements that share a name space have names of their own."""
    elements = [element for element in children(robot) if element.tagName in tags]
    for element in elements:
        if not element.getAttribute("name"):
            raise BadInput("", "", f"<{element.tagName}>: expected the attribute 'name'")
        if element.getAttribute("drake_ignore"):
            raise fault(element, "expected no attribute 'drake_ignore'; remove the element")
    for name, count in Counter(element.getAttribute("name") for element in elements).items():
        if count > 1:
            kinds = " and ".join(f"{tag}s" for tag in tags)
            problem = f"expected different names of {kinds}, got '{name}' {count} times"
            raise BadInput("", "", problem)


def _check_inertia(inertial: Element) -> None:
    """Raises BadInput if Drake would not accept a link's inertia and replace it."""
    mass, inertia = only_child(inertial, "mass"), only_child(inertial, "inertia")
    if mass is None or inertia is None:
        tag = "mass" if mass is None else "inertia"
        problem = f"<inertial>: missing <{tag}>; a link without mass has no <inertial>"
        raise fault(inertial, problem)
    only_child(inertial, "origin")
    moments = [float(inertia.getAttribute(name)) for name in MOMENTS]
    if not any(moments) and float(mass.getAttribute("value")) <= MARKER_KG:
        return
    I_B = RotationalInertia(*moments)
    principal = I_B.CalcPrincipalMomentsOfInertia()
    if not I_B.CouldBePhysicallyValid() or min(principal) <= ROUNDING * max(principal):
        given = ", ".join(f"{name}={inertia.getAttribute(name)}" for name in MOMENTS)
        got = ", ".join(f"{x:.4g}" for x in principal)
        raise fault(
            inertial,
            "<inertia>: expected principal moments that are positive, each at most the sum of the "
            f"other two, got {got} kg m^2 from {given}",
        )


def _check_geometry(element: Element) -> None:
    geometry = only_child(element, "geometry")
    shapes = list(children(geometry)) if geometry is not None else []
    if len(shapes) != 1 or shapes[0].tagName not in SHAPES:
        got = " and ".join(f"<{shape.tagName}>" for shape in shapes) or "none"
        names = ", ".join(f"<{name}>" for name in SHAPES)
        raise fault(element, f"<geometry>: expected one shape, {names}, got {got}")
    name = Path(shapes[0].getAttribute("filename")).name
    if element.tagName == "collision" and name and not name.lower().endswith(COLLISION_MESHES):
        raise fault(
            element,
            f"<mesh filename>: expected a mesh for collisions in {', '.join(COLLISION_MESHES)}, "
            f"got '{name}'; convert it, or use a box, cylinder, sphere or capsule",
        )
    for properties in children(element, "drake:proximity_properties"):
        friction = (attribute(properties, f"drake:mu_{kind}", "value") for kind in FRICTION)
        static, dynamic = friction
        if static and dynamic and float(dynamic) > float(static):
            problem = f"expected mu_dynamic up to mu_static, {static}, got {dynamic}"
            raise fault(element, f"<{properties.tagName}>: {problem}")
