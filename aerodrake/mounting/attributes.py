"""Numbers in the attributes of a foreign URDF, more of which are optional than in ours."""

import math
from xml.dom.minidom import Element

from aerodrake.model.vehicle.urdf_numbers import LARGEST
from aerodrake.mounting.pose import Pose
from aerodrake.support.decimals import read_decimal
from aerodrake.support.errors import BadInput
from aerodrake.support.urdf_element import child, fault

MACROS = ("${", "$(")
"""Beginnings of a macro in an attribute."""
INFINITE = ("inf", "infinity")


def read_numbers(
    element: Element | None, name: str, count: int, default: tuple[float, ...] | None = None
) -> tuple[float, ...]:
    """Returns the numbers of an attribute; its default if the attribute or element is missing.

    Raises:
        BadInput: if the text is not `count` decimal numbers, or missing without a default.
    """
    given = element.getAttribute(name) if element is not None else ""
    if not given.strip() and default is not None:
        return default
    numbers = tuple(map(read_decimal, given.split()))
    # The negation is also true of NaN.
    if len(numbers) != count or not all(abs(x) <= LARGEST for x in numbers):
        raise _not_numbers(element, name, count, given)
    return numbers


def read_magnitude(element: Element | None, name: str, unit: str) -> float:
    """Returns the number of an attribute that is not negative, zero without it.

    Raises:
        BadInput: if the text is no such number.
    """
    (number,) = read_numbers(element, name, 1, (0.0,))
    if number < 0:
        problem = f"expected a non-negative number in {unit}, got '{element.getAttribute(name)}'"
        raise fault(element, f"<{element.tagName} {name}>: {problem}")
    return number


def read_limit(element: Element | None, name: str) -> float | None:
    """Returns the number of an attribute that may be missing, or infinite with the same meaning.

    Raises:
        BadInput: if the text is no number.
    """
    given = element.getAttribute(name).strip() if element is not None else ""
    if not given or given.lower().lstrip("+-") in INFINITE:
        return None
    number = read_decimal(given)
    if math.isnan(number):
        raise _not_numbers(element, name, 1, given)
    return number if abs(number) <= LARGEST else None


def read_pose(element: Element) -> Pose:
    """Returns the `<origin>` of an element, zero without one.

    Raises:
        BadInput: if an attribute is unknown, or does not have three numbers.
    """
    if (origin := child(element, "origin")) is None:
        return Pose()
    for name, _ in origin.attributes.items():
        if name not in Pose._fields:
            raise fault(origin, f"<origin>: expected the attributes xyz and rpy, got '{name}'")
    return Pose(*(read_numbers(origin, name, 3, (0.0, 0.0, 0.0)) for name in Pose._fields))


def _not_numbers(element: Element, name: str, count: int, given: str) -> BadInput:
    noun = "a number" if count == 1 else f"{count} numbers"
    return fault(element, f"<{element.tagName} {name}>: expected {noun}, got {given!r}")


def refuse_macros(element: Element) -> None:
    """Raises BadInput if an attribute of an element, or of one inside it, has a macro of xacro."""
    for inner in (element, *element.getElementsByTagName("*")):
        for name, value in inner.attributes.items():
            if any(mark in value for mark in MACROS):
                problem = f"expected no macro, got '{value}'; expand it with the command `xacro`"
                raise fault(inner, f"<{inner.tagName} {name}>: {problem}")
