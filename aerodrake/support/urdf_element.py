"""Elements of a URDF: their children, their numbers, and their names in messages."""

import difflib
from collections.abc import Iterable, Iterator
from xml.dom.minidom import Element

from aerodrake.support.errors import BadInput

OWNERS = ("link", "joint", "frame", "transmission", "material")
"""Children of `<robot>` whose names locate a fault."""


def children(element: Element, tag: str = "") -> Iterator[Element]:
    """Yields the child elements, all of them or those with a tag."""
    for node in element.childNodes:
        if node.nodeType == Element.ELEMENT_NODE and tag in ("", node.tagName):
            yield node


def child(element: Element, tag: str) -> Element | None:
    """Returns the first child element with a tag, which is the one that Drake reads."""
    return next(children(element, tag), None)


def attribute(element: Element, tag: str, name: str) -> str:
    """Returns an attribute of the first child with a tag; empty without the child."""
    inner = child(element, tag)
    return inner.getAttribute(name) if inner is not None else ""


def text(element: Element) -> str:
    """Returns the text inside an element, without surrounding space."""
    parts = (node.data for node in element.childNodes if node.nodeType == Element.TEXT_NODE)
    return "".join(parts).strip()


def numbers(element: Element | None, name: str, default: str) -> list[float]:
    """Returns the numbers of an attribute that has been checked, or those of the default."""
    given = element.getAttribute(name) if element is not None else ""
    return [float(word) for word in (given or default).split()]


def owner(element: Element) -> str:
    """Returns the link, joint, frame, transmission or material that an element belongs to.

    Visual and collision geometry is numbered if its link has more than one.
    """
    part = ""
    while element.tagName not in OWNERS or element.parentNode.nodeName != "robot":
        if element.tagName in ("visual", "collision"):
            same = list(children(element.parentNode, element.tagName))
            part = f", {element.tagName}" + (f" {same.index(element) + 1}" if same[1:] else "")
        if element.parentNode.nodeType != Element.ELEMENT_NODE:
            return ""
        element = element.parentNode
    name = element.getAttribute("name")
    if element.tagName == "transmission" and (joint := attribute(element, "joint", "name")):
        return f"transmission of joint {joint}"
    return f"{element.tagName} {name}{part}".rstrip()


def fault(element: Element, message: str) -> BadInput:
    """Returns the error of an element; its source is the caller's to add."""
    return BadInput("", owner(element), message)


def misspelled(name: str, known: Iterable[str], similarity: float = 0.8) -> str:
    """Returns the known name that an unknown one resembles; empty if there is none."""
    close = difflib.get_close_matches(name, sorted(known), n=1, cutoff=similarity)
    return close[0] if close else ""
