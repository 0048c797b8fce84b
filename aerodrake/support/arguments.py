"""Checks of arguments: a wrong one is named, with what was expected, when a system is made.

A constructor or function with the decorator `checked` refuses arguments that are not of their
annotated types. `Annotated` adds a constraint:

    @checked
    def __init__(self, config: Allocation, period: Period): ...
"""

import functools
import inspect
import math
import types
import typing
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from numbers import Integral, Real
from operator import attrgetter
from typing import Annotated, Any, NamedTuple, TypeVar

import numpy as np

from aerodrake.support.errors import BadInput, show
from aerodrake.support.limits import SEED

F = TypeVar("F", bound=Callable[..., Any])


class Interval(NamedTuple):
    """Numbers from `low` to `high` in `unit`; `low` itself only if it is included."""

    low: float
    high: float = math.inf
    unit: str = ""
    includes_low: bool = True

    def problem(self, value: float) -> str:
        """Returns what is expected of a number, empty if it is in the range."""
        is_above = self.low <= value if self.includes_low else self.low < value
        if is_above and value <= self.high:
            return ""
        if self.high < math.inf:
            expected = f"expected a number in [{self.low:.10g}, {self.high:.10g}]"
        else:
            expected = f"expected {self.low:g} or more"
            if not self.includes_low:
                expected = f"expected more than {self.low:g}"
        return f"{expected}{self.unit and f' {self.unit}'}, got {show(value)}"


class Size(NamedTuple):
    """Vectors of `constant` + `multiple` n numbers, with a whole n of 0 or more."""

    constant: int
    multiple: int = 0

    def problem(self, value: Any) -> str:
        """Returns what is expected of an array, empty if it has the size."""
        shape = np.shape(value)
        extra = shape[0] - self.constant if len(shape) == 1 else -1
        if extra == 0 or (extra > 0 and self.multiple and extra % self.multiple == 0):
            return ""
        numbers = f"{self.constant} + {self.multiple} n" if self.multiple else f"{self.constant}"
        got = "x".join(map(str, shape))
        return f"expected an array of {numbers} numbers, got {got or 'a number'}"


class Timed(NamedTuple):
    """Equations whose `attribute` is a period in s."""

    attribute: str

    def problem(self, value: Any) -> str:
        """Returns what is expected of the period, empty if it is above 0."""
        problem = _problem(Period, attrgetter(self.attribute)(value))
        return f"{self.attribute}: {problem}" if problem else ""


Period = Annotated[float, Interval(0.0, unit="s", includes_low=False)]
Duration = Annotated[float, Interval(0.0, unit="s")]
Count = Annotated[int, Interval(1)]
Seed = Annotated[int, Interval(*SEED)]
Vector3 = Annotated[np.ndarray, Size(3)]
Vector6 = Annotated[np.ndarray, Size(6)]
StateVector = Annotated[np.ndarray, Size(13, 2)]
Vector = Annotated[np.ndarray, Size(1, 1)]
Axes = Annotated[np.ndarray, Size(3, 1)]


def checked(function: F) -> F:
    """Makes a function or constructor refuse arguments that differ from their annotations.

    Numbers must be finite, and so must arrays, which may be given as lists. Sequences are checked
    item by item. Arguments are passed on unchanged.

    Raises:
        BadInput: with the name of the function or class, that of the argument, and what was
            expected.
    """
    signature = inspect.signature(function)
    name = function.__qualname__.removesuffix(".__init__")

    @functools.cache
    def hints() -> dict[str, Any]:
        return dict(_hints(function))

    @functools.wraps(function)
    def wrapper(*args: Any, **kwargs: Any) -> Any:
        for argument, value in signature.bind(*args, **kwargs).arguments.items():
            if argument in hints() and (problem := _problem(hints()[argument], value)):
                raise BadInput(name, argument, problem)
        return function(*args, **kwargs)

    return typing.cast(F, wrapper)


def check_whole(argument: str, value: object, low: int, high: int) -> None:
    """Raises BadInput that names an argument unless its value is a whole number in [low, high]."""
    if _problem(int, value) or not low <= value <= high:
        expected = f"expected a whole number in [{low}, {high}]"
        raise BadInput(argument, "", f"{expected}, got {show(value)}")


def _hints(function: Callable[..., Any]) -> Iterator[tuple[str, Any]]:
    """Yields name and type of the arguments whose types are imported at run time."""
    for name, annotation in inspect.get_annotations(function).items():
        alone = types.SimpleNamespace(__annotations__={name: annotation})
        with suppress(NameError):  # torch takes a second to import.
            hints = typing.get_type_hints(alone, function.__globals__, include_extras=True)
            yield name, hints[name]


def _problem(hint: Any, value: Any) -> str:
    """Returns what is expected of a value, empty if it fits its annotation."""
    kind, arguments = typing.get_origin(hint), typing.get_args(hint)
    if kind is Annotated:
        problems = (constraint.problem(value) for constraint in hint.__metadata__)
        return _problem(arguments[0], value) or next(filter(None, problems), "")
    if hint is Any:
        return ""
    if hint is float:
        is_number = isinstance(value, Real) and not isinstance(value, bool | np.bool_)
        is_valid, expected = is_number and math.isfinite(value), "a number"
    elif hint is int:
        is_valid = isinstance(value, Integral) and not isinstance(value, bool)
        expected = "a whole number"
    elif hint is np.ndarray:
        is_valid, expected = _is_finite(value), "an array of finite numbers"
    elif kind in (types.UnionType, typing.Union):
        expected = " or ".join(_name(option) for option in arguments)
        is_valid = any(not _problem(option, value) for option in arguments)
    elif kind in (Sequence, tuple):
        expected = f"a list of {_name(arguments[0])}"
        is_valid = isinstance(value, Sequence) and not isinstance(value, str)
        is_valid = is_valid and not any(_problem(arguments[0], item) for item in value)
    elif isinstance(kind or hint, type):
        is_valid, expected = isinstance(value, kind or hint), _name(hint)
    else:
        is_valid, expected = True, ""
    return "" if is_valid else f"expected {expected}, got {show(value)}"


def _is_finite(value: Any) -> bool:
    try:
        return bool(np.isfinite(np.asarray(value, dtype=float)).all())
    except (TypeError, ValueError):
        return False


def _name(hint: Any) -> str:
    if typing.get_origin(hint) is Annotated:
        return _name(hint.__origin__)
    return "None" if hint is types.NoneType else getattr(hint, "__name__", str(hint))
