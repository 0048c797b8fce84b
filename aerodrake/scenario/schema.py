"""Declaration of sections as dataclasses, and their conversion from and to plain mappings.

A section of a scenario is a frozen dataclass. Each field declares its unit and range:

    amplitude_m: float = quantity(0.5, "m", 0.01, 5.0)

`build` converts a mapping, as parsed from YAML, to such a dataclass. Its errors name the
dotted key, the unit, the range and the nearest valid name. For a field whose type is a union
of dataclasses, the key `kind` selects the class. A tuple of such a union is a list of mappings.
"""

import dataclasses
import math
import os
import reprlib
import types
import typing
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar

from aerodrake.scenario.renamed import successor
from aerodrake.support.errors import ScenarioError, nearest
from aerodrake.support.files import PACKAGE, is_packaged, leaves_package

_REPR = reprlib.Repr()  # Limits the depth and length of values in messages.
_REPR.maxlevel = 2
_REPR.maxstring = 60

MAX_LIST = 1000
"""Longest list in a scenario; protects against hostile files."""


def quantity(
    default: float | tuple[float, ...],
    unit: str,
    low: float = -math.inf,
    high: float = math.inf,
    *,
    length: int | None = None,
) -> Any:
    """Declares a number, or a tuple of them, with its unit and closed range.

    Args:
        default: The value if the scenario has none; its type (int, float or tuple) is
            the field's.
        unit: The unit in messages; "1" for none.
        low: Smallest valid value (of each element).
        high: Largest valid value (of each element).
        length: The number of elements of a tuple; None for a list with one value per joint,
            whose number depends on the robot.
    """
    metadata = {"unit": unit, "low": low, "high": high, "length": length}
    return dataclasses.field(default=default, metadata=metadata)


def choice(default: str, *others: str) -> Any:
    """Declares a string that must be `default` or one of `others`."""
    return dataclasses.field(default=default, metadata={"options": (default, *others)})


def file(default: str = "") -> Any:
    """Declares a path, taken relative to the scenario file; empty for none."""
    return dataclasses.field(default=default, metadata={"file": True})


def provenance() -> Any:
    """Declares a string that names the source of the data and is not part of it."""
    return dataclasses.field(default="", metadata={"provenance": True})


class Kind:
    """Base of dataclasses of a union; their keyword `kind` is the value of that key."""

    kind: ClassVar[str]

    def __init_subclass__(cls, kind: str = ""):
        cls.kind = kind


def build(cls: type, data: object, source: object, key: str = "") -> Any:
    """Converts a mapping to the dataclass `cls`.

    Args:
        cls: A dataclass whose fields are declared with this module.
        data: The mapping.
        source: Named in errors: the file or option that `data` came from.
        key: Dotted key of `data` in the source.

    Returns:
        An instance of `cls`, with defaults for keys that are not in `data`.

    Raises:
        ScenarioError: on unknown or renamed keys, wrong types, lengths or ranges.
    """
    if not isinstance(data, Mapping):
        raise ScenarioError(source, key, f"expected a mapping of keys to values, got {_show(data)}")
    return cls(**{name: convert_field(cls, name, data[name], source, key) for name in data})


def convert_field(cls: type, name: str, value: object, source: object, key: str = "") -> Any:
    """Converts the value of one field of the dataclass `cls`.

    Args:
        cls: A dataclass whose fields are declared with this module.
        name: Name of the field.
        value: A plain value as parsed from YAML, an array, a path, or a section.
        source: Named in errors.
        key: Dotted key of the dataclass in the source.

    Raises:
        ScenarioError: as for `build`.
    """
    dotted = f"{key}.{name}" if key else str(name)
    fields = {f.name: f for f in _data_fields(cls)}
    if name not in fields:
        advice = successor(dotted) or f"unknown key; {nearest(name, fields)}"
        raise ScenarioError(source, dotted, advice)
    hint = typing.get_type_hints(cls)[name]
    return _convert(hint, fields[name].metadata, value, source, dotted)


def as_mapping(config: Any) -> dict[str, Any]:
    """Returns a mapping of every key of `config`, defaults included: the inverse of `build`."""

    def plain(value: Any) -> Any:
        if dataclasses.is_dataclass(value):
            data = {f.name: plain(getattr(value, f.name)) for f in _data_fields(value)}
            return {"kind": value.kind, **data} if hasattr(value, "kind") else data
        if isinstance(value, tuple):
            return [plain(v) for v in value]
        return value

    return plain(config)


def flat(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Returns the values of nested mappings by dotted key."""
    values: dict[str, Any] = {}
    for name, value in data.items():
        key = f"{prefix}{name}"
        values |= flat(value, f"{key}.") if isinstance(value, dict) else {key: value}
    return values


def map_files(config: Any, change: typing.Callable[[Path], Path]) -> Any:
    """Returns `config` with `change` applied to every file that is not in the package."""
    changes: dict[str, Any] = {}
    for f in dataclasses.fields(config):
        value = getattr(config, f.name)
        if dataclasses.is_dataclass(value):
            changes[f.name] = map_files(value, change)
        elif f.metadata.get("file") and value and not is_packaged(value):
            changes[f.name] = str(change(Path(value)))
    return dataclasses.replace(config, **changes)


def _data_fields(config: Any) -> list[dataclasses.Field]:
    return [f for f in dataclasses.fields(config) if "provenance" not in f.metadata]


def _convert(hint: Any, meta: Mapping[str, Any], value: object, source: object, key: str) -> Any:
    if hasattr(value, "tolist"):  # Arrays, and NumPy's numbers.
        value = value.tolist()
    if isinstance(hint, types.UnionType):
        return _build_union(typing.get_args(hint), value, source, key)
    if dataclasses.is_dataclass(hint):
        if dataclasses.is_dataclass(value):
            return _section((hint,), value, source, key)
        return build(hint, value, source, key)
    if hint is bool:
        if not isinstance(value, bool):
            raise ScenarioError(source, key, f"expected true or false, got {_show(value)}")
        return value
    if hint is str:
        return _string(meta, value, source, key)
    if hint in (int, float):
        return _number(hint, meta, value, source, key)
    element = typing.get_args(hint)[0]
    if isinstance(element, types.UnionType):
        if not isinstance(value, list | tuple):
            raise ScenarioError(source, key, f"expected a list of mappings, got {_show(value)}")
        if len(value) > MAX_LIST:
            raise ScenarioError(source, key, f"expected at most {MAX_LIST} items, got {len(value)}")
        kinds = typing.get_args(element)
        return tuple(_build_union(kinds, v, source, f"{key}[{i}]") for i, v in enumerate(value))
    length = f"{meta['length']} " if meta["length"] else ""
    unit = "" if meta["unit"] == "1" else f" in {meta['unit']}"
    expected = f"expected a list of {length}numbers{unit}"
    if not isinstance(value, list | tuple):
        raise ScenarioError(source, key, f"{expected}, got {_show(value)}")
    if len(value) > MAX_LIST or (meta["length"] and len(value) != meta["length"]):
        raise ScenarioError(source, key, f"{expected}, got {len(value)}")
    return tuple(_number(element, meta, v, source, f"{key}[{i}]") for i, v in enumerate(value))


def _build_union(options: tuple[type, ...], value: object, source: object, key: str) -> Any:
    if dataclasses.is_dataclass(value):
        return _section(options, value, source, key)
    kinds = {option.kind: option for option in options}
    kind = value.get("kind") if isinstance(value, Mapping) else None
    if kind is None:
        raise ScenarioError(source, key, f"expected a mapping with a kind; {nearest('', kinds)}")
    if not isinstance(kind, str) or kind not in kinds:
        message = f"unknown kind {_show(kind)}; {nearest(kind, kinds)}"
        raise ScenarioError(source, f"{key}.kind", message)
    return build(kinds[kind], {k: v for k, v in value.items() if k != "kind"}, source, key)


def _section(options: tuple[type, ...], value: object, source: object, key: str) -> Any:
    """Returns a section that was built in Python, after a check of its class."""
    if isinstance(value, options):
        return value
    names = " or ".join(option.__name__ for option in options)
    raise ScenarioError(source, key, f"expected {names}, got {_show(value)}")


def _string(meta: Mapping[str, Any], value: object, source: object, key: str) -> str:
    options = meta.get("options")
    if meta.get("file") and isinstance(value, os.PathLike):
        value = os.fspath(value)
    if not isinstance(value, str):
        raise ScenarioError(source, key, f"expected a string, got {_show(value)}")
    if options and value not in options:
        raise ScenarioError(source, key, f"unknown value {_show(value)}; {nearest(value, options)}")
    if not value.isprintable():
        raise ScenarioError(source, key, f"expected printable text, got {_show(value)}")
    if meta.get("file") and is_packaged(value) and leaves_package(value):
        message = f"expected {PACKAGE}... of a file in the package, got {_show(value)}"
        raise ScenarioError(source, key, message)
    return value


def _number(hint: type, meta: Mapping[str, Any], value: object, source: object, key: str) -> float:
    low, high = meta["low"], meta["high"]
    kind = "a whole number" if hint is int else "a number"
    unit = "" if meta["unit"] == "1" else f" {meta['unit']}"
    expected = f"expected {kind} in [{low:.10g}, {high:.10g}]{unit}"
    problem = ScenarioError(source, key, f"{expected}, got {_show(value)}")
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise problem
    try:
        number = float(value)
    except OverflowError:
        raise problem from None
    if not math.isfinite(number) or not low <= number <= high:
        raise problem
    if hint is int and number != int(number):
        raise problem
    return hint(number)


def _show(value: object) -> str:
    return _REPR.repr(value)
