"""Robots whose links are not what their URDF says, as a plant may be off its model."""

from __future__ import annotations

from pathlib import Path
from xml.dom import expatbuilder
from xml.dom.minidom import Element
from xml.parsers.expat import ExpatError

from aerodrake.errors import BadInput
from aerodrake.world import Mismatch

EXACT = Mismatch()
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def is_exact(mismatch: Mismatch) -> bool:
    """Whether the links are as their URDF has them."""
    return mismatch.mass_scale == mismatch.inertia_scale == 1


def mismatched_urdf(path: Path, mismatch: Mismatch) -> str:
    """A URDF with every link's mass, and inertia about its centre of mass, by their factors.

    A URDF states just these two numbers, so that they are scaled in its text: a
    body welded to the link could not add to the one without the other.

    Args:
        path: The URDF; meshes relative to it are named by absolute URIs in the result.
        mismatch: The factors.

    Raises:
        BadInput: if it is no URDF.
    """
    try:
        # Prefixes such as `drake:` are part of a name for Drake, declared or not.
        document = expatbuilder.parse(str(path), namespaces=False)
    except ExpatError as error:
        raise BadInput(path, "", f"mismatch of links expects a URDF: {error}") from None
    if document.documentElement.tagName != "robot":
        raise BadInput(path, "", "mismatch of links expects a URDF, whose root is <robot>")
    for link in document.getElementsByTagName("inertial"):
        for mass in link.getElementsByTagName("mass"):
            _scale(mass, ("value",), mismatch.mass_scale)
        for inertia in link.getElementsByTagName("inertia"):
            _scale(inertia, MOMENTS, mismatch.inertia_scale)
    for mesh in document.getElementsByTagName("mesh"):
        file = mesh.getAttribute("filename")
        if "://" not in file:
            mesh.setAttribute("filename", f"file://{path.absolute().parent / file}")
    return document.toxml()


def _scale(element: Element, attributes: tuple[str, ...], factor: float) -> None:
    for name in attributes:
        if element.hasAttribute(name):
            element.setAttribute(name, repr(factor * float(element.getAttribute(name))))
