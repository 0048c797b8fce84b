"""Numbers of a URDF: the elements that have them, their count, unit and range."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from xml.dom.minidom import Element

from aerodrake.support.decimals import read_decimal
from aerodrake.support.urdf_element import children, fault, misspelled, text

LARGEST = 1e9
"""Largest magnitude of a number."""
SPACE = " \t\r\n"
TEXT = ""
"""Key, in the tables, of the text inside an element."""
DRAKE = "drake:"
"""Prefix of the elements and attributes that only Drake has."""
MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
"""Attributes of `<inertia>`: moments and products of inertia."""


@dataclass(frozen=True)
class Range:
    """Range of a number.

    Attributes:
        name: The range in words.
        contains: Returns True for a number in the range.
    """

    name: str
    contains: Callable[[float], bool]


ANY = Range("", lambda x: True)
POSITIVE = Range("positive", lambda x: x > 0)
NOT_NEGATIVE = Range("non-negative", lambda x: x >= 0)
NONZERO = Range("nonzero", lambda x: abs(x) >= 1e-8)
FRACTION = Range("", lambda x: 0 <= x <= 1)


@dataclass(frozen=True)
class Expected:
    """Numbers of one attribute.

    Attributes:
        unit: Their unit, or an interval; empty for pure numbers.
        range: The range of each.
        counts: Valid counts.
        is_required: True if the attribute cannot be left out.
        advice: A way out for numbers that are not in the range.
    """

    unit: str = ""
    range: Range = ANY
    counts: tuple[int, ...] = (1,)
    is_required: bool = False
    advice: str = ""

    def __str__(self) -> str:
        count = "a" if self.counts == (1,) else " or ".join(map(str, self.counts))
        noun = "number" if self.counts == (1,) else "numbers"
        unit = f"in {self.unit}" if self.unit else ""
        return " ".join(filter(None, (count, self.range.name, noun, unit)))

    def fits(self, words: list[str]) -> bool:
        """Returns True if words have the right count, and are decimal numbers in the range.

        Of other text Drake would read the beginning.
        """
        numbers = map(read_decimal, words)
        return len(words) in self.counts and all(
            abs(number) <= LARGEST and self.range.contains(number) for number in numbers
        )


POSE = {"xyz": Expected("m", counts=(3,)), "rpy": Expected("rad", counts=(3,))}
POSE_ATTRIBUTES = {"name", "link", "drake_ignore"}
"""Attributes of elements with a pose that are not numbers."""
SIZE = Expected("m", POSITIVE, is_required=True)
CYLINDER = {"radius": SIZE, "length": SIZE}
SHAPES = {
    "box": {"size": Expected("m", POSITIVE, (3,), is_required=True)},
    "sphere": {"radius": Expected("m", NOT_NEGATIVE, is_required=True)},
    "cylinder": CYLINDER,
    "capsule": CYLINDER,
    "drake:capsule": CYLINDER,
    "drake:ellipsoid": {"a": SIZE, "b": SIZE, "c": SIZE},
    "mesh": {"scale": Expected(range=NONZERO, counts=(1, 3))},
}
"""Shapes of geometry, with their attributes."""
MASS = Expected("kg", POSITIVE, (1,), True, "a link without mass has no <inertial>")
COLOR = {"rgba": Expected("[0, 1]", FRACTION, (4,), is_required=True)}
PROXIMITY = "link/collision/drake:proximity_properties/drake:"

NUMBERS: dict[str, dict[str, Expected]] = {
    "frame": POSE,
    "material/color": COLOR,
    "link/inertial/origin": POSE,
    "link/inertial/mass": {"value": MASS},
    "link/inertial/inertia": {m: Expected("kg m^2", is_required=True) for m in MOMENTS},
    "link/visual/origin": POSE,
    "link/visual/material/color": COLOR,
    "link/collision/origin": POSE,
    "link/collision/drake_compliance/static_friction": {TEXT: Expected("", NOT_NEGATIVE)},
    "link/collision/drake_compliance/dynamic_friction": {TEXT: Expected("", NOT_NEGATIVE)},
    "joint/origin": POSE,
    "joint/axis": {"xyz": Expected(counts=(3,), is_required=True)},
    "joint/limit": {
        "lower": Expected("rad"),
        "upper": Expected("rad"),
        "effort": Expected("N m"),
        "velocity": Expected("rad/s"),
        "drake:acceleration": Expected("rad/s^2"),
    },
    "joint/dynamics": {
        "damping": Expected("N m s/rad", NOT_NEGATIVE),
        "friction": Expected("N m", NOT_NEGATIVE),
    },
    "transmission/mechanicalReduction": {TEXT: Expected("", NONZERO)},
    "transmission/actuator/mechanicalReduction": {TEXT: Expected("", NONZERO)},
    "transmission/actuator/drake:gear_ratio": {"value": Expected("", NONZERO, is_required=True)},
    "transmission/actuator/drake:rotor_inertia": {
        "value": Expected("kg m^2", NOT_NEGATIVE, is_required=True)
    },
    **{
        f"link/{role}/geometry/{shape}": attributes
        for role in ("visual", "collision")
        for shape, attributes in SHAPES.items()
    },
    **{
        f"{PROXIMITY}{name}": {"value": Expected(range=NOT_NEGATIVE, is_required=True)}
        for name in (
            "mu_static",
            "mu_dynamic",
            "hunt_crossley_dissipation",
            "point_contact_stiffness",
            "hydroelastic_modulus",
            "hydroelastic_margin",
            "mesh_resolution_hint",
            "relaxation_time",
        )
    },
}
"""Numbers by the path of their element below `<robot>` and the name of their attribute."""


def _tags() -> dict[str, set[str]]:
    """Returns the tags of the children that have numbers, or contain them, by their path."""
    tags: dict[str, set[str]] = {}
    for path in NUMBERS:
        while path:
            path, _, tag = path.rpartition("/")
            tags.setdefault(path, set()).add(tag)
    return tags


TAGS = _tags()
"""Tags of the children that have numbers, or contain them, by the path of their parent."""


def check_numbers(robot: Element) -> None:
    """Checks all numbers of a URDF, and removes superfluous space around them.

    Elements that neither Drake nor this package reads, such as `<gazebo>`, are not checked.

    Raises:
        BadInput: if a number is malformed, out of its range, infinite or missing; if their count
            is wrong; if the name of an element or attribute is a misspelled one of the tables.
    """
    _check_children(robot, "")


def _check_children(element: Element, path: str) -> None:
    known = TAGS.get(path, set())
    for inner in children(element) if known else ():
        tag = inner.tagName
        if tag in known:
            below = f"{path}/{tag}" if path else tag
            _check_attributes(inner, NUMBERS.get(below, {}))
            _check_children(inner, below)
        elif path and not tag.startswith(DRAKE) and (right := _meant(tag, known)):
            raise fault(inner, f"expected no element <{tag}>; did you mean <{right}>?")


def _meant(tag: str, known: set[str]) -> str:
    """Returns the known tag that another resembles, or is without `drake:`; else empty."""
    return DRAKE + tag if DRAKE + tag in known else misspelled(tag, known)


def _check_attributes(element: Element, table: dict[str, Expected]) -> None:
    given = dict(element.attributes.items())
    if table is POSE and (unknown := given.keys() - POSE_ATTRIBUTES - POSE.keys()):
        problem = f"expected no attribute '{min(unknown)}'"
        right = misspelled(min(unknown), POSE, similarity=0.6)
        advice = f"did you mean '{right}'?" if right else f"valid: {', '.join(POSE)}"
        raise fault(element, f"<{element.tagName}>: {problem}; {advice}")
    for name, expected in table.items():
        place = f"<{element.tagName} {name}>" if name else f"<{element.tagName}>"
        if name and name not in given:
            for other in given.keys() - table.keys():
                if misspelled(other, [name], similarity=0.6):
                    message = f"expected no attribute '{other}'; did you mean '{name}'?"
                    raise fault(element, f"<{element.tagName}>: {message}")
            if expected.is_required:
                got = f", got the text '{text(element)}'" if text(element) else ""
                raise fault(element, f"{place}: missing; expected {expected}{got}")
            continue
        value = given[name] if name else text(element)
        words = value.strip(SPACE).split()
        if not value.isascii() or not expected.fits(words):
            most = f" of magnitude {LARGEST:g} or less" if _is_large(words) else ""
            is_number = words and not most and not any(map(math.isnan, map(read_decimal, words)))
            advice = f"; {expected.advice}" if is_number and expected.advice else ""
            raise fault(element, f"{place}: expected {expected}{most}, got {value!a}{advice}")
        if name and value != " ".join(words):
            # Drake takes a scale for one number unless there is a plain space in it.
            element.setAttribute(name, " ".join(words))
    if table and TEXT not in table and text(element):
        names = ", ".join(table)
        problem = f"expected numbers in the attributes {names}, got the text '{text(element)}'"
        raise fault(element, f"<{element.tagName}>: {problem}")


def _is_large(words: list[str]) -> bool:
    """Returns True if one of the words is a number whose magnitude is too large."""
    return any(abs(read_decimal(word)) > LARGEST for word in words)
