"""Robots whose links are not what their URDF says, as a plant may be off its model."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from xml.dom.minidom import Element

from aerodrake.scenario import Mismatch
from aerodrake.support.errors import BadInput
from aerodrake.support.urdf import parse_urdf, urdf_content

EXACT = Mismatch()
"""That of a plant that is as its files have it."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Of inertia, as URDF calls them."""


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
        BadInput: as `read_urdf`, or where a number is none.
    """
    # A run parses its robot a dozen times, and asks for its text as often.
    return _mismatched(path, path.absolute(), urdf_content(path), mismatch)


@lru_cache(maxsize=16)
def _mismatched(path: Path, place: Path, content: bytes, mismatch: Mismatch) -> str:
    """The same for the file's place and content, which it depends on."""
    document = parse_urdf(path, content)
    if is_exact(mismatch):
        return document.toxml()
    try:
        for link in document.getElementsByTagName("inertial"):
            for mass in link.getElementsByTagName("mass"):
                _scale(mass, ("value",), mismatch.mass_scale)
            for inertia in link.getElementsByTagName("inertia"):
                _scale(inertia, MOMENTS, mismatch.inertia_scale)
    except ValueError as error:
        raise BadInput(path, "", f"mismatch of links: {error}") from None
    return document.toxml()


def _scale(element: Element, attributes: tuple[str, ...], factor: float) -> None:
    for name in attributes:
        if element.hasAttribute(name):
            element.setAttribute(name, repr(factor * float(element.getAttribute(name))))
