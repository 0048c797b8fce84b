"""Conversion of plain values to those of a section: numbers, tuples, strings and booleans."""

import math
import os
from collections.abc import Mapping
from contextlib import suppress
from typing import Any

from aerodrake.support.errors import ScenarioError, nearest, show
from aerodrake.support.files import PACKAGE, is_packaged, leaves_package

MAX_LIST = 1000
"""Longest list in a scenario; protects against hostile files."""


def plain(value: object) -> Any:
    """Returns an array or a NumPy number as lists and numbers of Python, others unchanged."""
    return value.tolist() if hasattr(value, "tolist") else value


def boolean(value: object, source: object, key: str) -> bool:
    """Returns a value that must be true or false; `source` and `key` are named in errors."""
    if not isinstance(value, bool):
        raise ScenarioError(source, key, f"expected true or false, got {show(value)}")
    return value


def string(meta: Mapping[str, Any], value: object, source: object, key: str) -> str:
    """Returns a value that must be a string as declared in `meta`: a choice, a file or a name."""
    options = meta.get("options")
    if meta.get("file") and isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, str):
        raise ScenarioError(source, key, f"expected a string, got {show(value)}")
    if options and value not in options:
        raise ScenarioError(source, key, f"unknown value {show(value)}; {nearest(value, options)}")
    if not value.isprintable():
        raise ScenarioError(source, key, f"expected printable text, got {show(value)}")
    if meta.get("file") and is_packaged(value) and leaves_package(value):
        message = f"expected {PACKAGE}... of a file in the package, got {show(value)}"
        raise ScenarioError(source, key, message)
    return str(value)


def number(hint: type, meta: Mapping[str, Any], value: object, source: object, key: str) -> float:
    """Returns a value that must be a number of the type `hint` in the range of `meta`."""
    low, high = meta["low"], meta["high"]
    value = plain(value)
    if isinstance(value, int | float) and not isinstance(value, bool):
        with suppress(OverflowError):
            result = float(value)
            is_whole = hint is float or result.is_integer()
            if math.isfinite(result) and low <= result <= high and is_whole:
                return hint(result)
    kind = "a whole number" if hint is int else "a number"
    unit = "" if meta["unit"] == "1" else f" {meta['unit']}"
    expected = f"expected {kind} in [{low:.10g}, {high:.10g}]{unit}"
    raise ScenarioError(source, key, f"{expected}, got {show(value)}")


def numbers(
    hint: type, meta: Mapping[str, Any], value: object, source: object, key: str
) -> tuple[float, ...]:
    """Returns a value that must be a list of numbers of the type `hint`, as long as declared."""
    length = f"{meta['length']} " if meta["length"] else ""
    unit = "" if meta["unit"] == "1" else f" in {meta['unit']}"
    expected = f"expected a list of {length}numbers{unit}"
    if not isinstance(value, list | tuple):
        raise ScenarioError(source, key, f"{expected}, got {show(value)}")
    if len(value) > MAX_LIST or (meta["length"] and len(value) != meta["length"]):
        raise ScenarioError(source, key, f"{expected}, got {len(value)}")
    return tuple(number(hint, meta, v, source, f"{key}[{i}]") for i, v in enumerate(value))
