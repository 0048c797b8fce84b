"""Visual and collision geometry of a foreign URDF."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from xml.dom.minidom import Element

from aerodrake.model.vehicle.urdf_links import only_child
from aerodrake.mounting.attributes import read_numbers, read_pose
from aerodrake.mounting.link import Geometry
from aerodrake.support.errors import BadInput
from aerodrake.support.urdf_element import child, children, owner

ROUND = (("radius", 1), ("length", 1))
ATTRIBUTES = {
    "box": (("size", 3),),
    "sphere": (("radius", 1),),
    "cylinder": ROUND,
    "drake:capsule": ROUND,
    "drake:ellipsoid": (("a", 1), ("b", 1), ("c", 1)),
    "mesh": (("scale", 3),),
}
"""Attributes of each shape, and the count of their numbers."""
ALIASES = {"capsule": "drake:capsule"}
MOST_COLOR = 255.0
"""Largest value of a colour in a file that has bytes instead of fractions."""


@dataclass
class ShapeReader:
    """Reader of geometry, which collects what it leaves out.

    Attributes:
        find: Returns the file that a URI names, or None.
        colors: Colours of the materials that the robot defines, by name.
        missing: URIs of meshes without a file.
        unreadable: Places of geometry without a usable shape.
    """

    find: Callable[[str], Path | None]
    colors: dict[str, tuple[float, ...]] = field(default_factory=dict)
    missing: dict[str, None] = field(default_factory=dict)
    unreadable: dict[str, None] = field(default_factory=dict)

    def read(self, link: Element, role: str) -> tuple[Geometry, ...]:
        """Returns a link's geometry of a role, `visual` or `collision`."""
        geometries = (self._geometry(element) for element in children(link, role))
        return tuple(geometry for geometry in geometries if geometry is not None)

    def define(self, material: Element) -> None:
        """Remembers the colour of a material of the robot, or of a link."""
        name, color = material.getAttribute("name"), read_color(material)
        if color is not None:
            self.colors.setdefault(name, color)

    def _geometry(self, element: Element) -> Geometry | None:
        outer = only_child(element, "geometry")
        shapes = list(children(outer)) if outer is not None else []
        tag = ALIASES.get(shapes[0].tagName, shapes[0].tagName) if shapes else ""
        if len(shapes) != 1 or tag not in ATTRIBUTES:
            self.unreadable[owner(element)] = None
            return None
        numbers, file = _read_shape(shapes[0], tag), None
        if not all(numbers) or (tag != "mesh" and min(numbers) < 0):
            self.unreadable[owner(element)] = None
            return None
        if tag == "mesh":
            uri = shapes[0].getAttribute("filename")
            if (file := self.find(uri)) is None:
                self.missing[uri] = None
                return None
        return Geometry(read_pose(element), tag, numbers, file, self._color(element))

    def _color(self, element: Element) -> tuple[float, ...] | None:
        material = child(element, "material")
        if material is None:
            return None
        return read_color(material) or self.colors.get(material.getAttribute("name"))


def _read_shape(shape: Element, tag: str) -> tuple[float, ...]:
    if tag == "mesh":
        words = shape.getAttribute("scale").split()
        if len(words) == 1:
            return read_numbers(shape, "scale", 1) * 3
        return read_numbers(shape, "scale", 3, (1.0, 1.0, 1.0))
    return sum((read_numbers(shape, name, count) for name, count in ATTRIBUTES[tag]), ())


def read_color(material: Element) -> tuple[float, ...] | None:
    """Returns the colour of a material in fractions; None without a readable one."""
    color = child(material, "color")
    if color is None:
        return None
    count = len(color.getAttribute("rgba").split())
    try:
        rgba = (*read_numbers(color, "rgba", count if count in (3, 4) else 4), 1.0)[:4]
    except BadInput:  # A picture without a colour is better than none.
        return None
    most = MOST_COLOR if max(rgba[:3]) > 1 else 1.0
    alpha = rgba[3] / MOST_COLOR if rgba[3] > 1 else rgba[3]
    return tuple(min(max(x, 0.0), 1.0) for x in (*(x / most for x in rgba[:3]), alpha))
