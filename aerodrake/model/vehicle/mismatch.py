"""Model mismatch: links of the plant that differ from their URDF."""

from xml.dom.minidom import Document, Element

from aerodrake.scenario import Mismatch
from aerodrake.support.errors import BadInput

EXACT = Mismatch()
"""No mismatch."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of `<inertia>` in a URDF."""


def scaled_urdf(robot: str, document: Document, mismatch: Mismatch) -> str:
    """Returns a URDF's text with the mass and central inertia of every link scaled.

    The numbers are scaled in the description, since a body welded to a link could not
    add to its mass without adding to its inertia.

    Args:
        robot: URI or path of the URDF, for messages.
        document: Its XML, which stays as it is.
        mismatch: The factors.

    Raises:
        BadInput: if a number in the file is malformed.
    """
    if mismatch.mass_scale == mismatch.inertia_scale == 1:
        return document.toxml()
    document = document.cloneNode(deep=True)
    try:
        for link in document.getElementsByTagName("inertial"):
            for mass in link.getElementsByTagName("mass"):
                _scale(mass, ("value",), mismatch.mass_scale)
            for inertia in link.getElementsByTagName("inertia"):
                _scale(inertia, MOMENTS, mismatch.inertia_scale)
    except ValueError as error:
        raise BadInput(robot, "", f"mismatch of links: {error}") from None
    return document.toxml()


def _scale(element: Element, attributes: tuple[str, ...], factor: float) -> None:
    for name in attributes:
        if element.hasAttribute(name):
            element.setAttribute(name, repr(factor * float(element.getAttribute(name))))
