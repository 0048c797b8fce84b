"""Numbers in the attributes of a foreign URDF, more of which are optional than in ours."""

import math
from xml.dom.minidom import Element

from aerodrake.model.vehicle.urdf_numbers import LARGEST
from aerodrake.mounting.arm import Pose
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
    """Returns the `<origin>` of an element, zero without one."""
    origin = child(element, "origin")
    return Pose(*(read_numbers(origin, name, 3, (0.0, 0.0, 0.0)) for name in ("xyz", "rpy")))


def _not_numbers(element: Element, name: str, count: int, given: str) -> BadInput:
    noun = "a number" if count == 1 else f"{count} numbers"
    is_macro = any(mark in given for mark in MACROS)
    advice = "; expand the macros with the command `xacro`" if is_macro else ""
    message = f"<{element.tagName} {name}>: expected {noun}, got {given!r}{advice}"
    return fault(element, message)
