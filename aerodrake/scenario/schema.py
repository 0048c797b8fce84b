"""Declaration of sections as dataclasses, and their conversion from and to plain mappings.

A section of a scenario is a frozen dataclass. Each field declares its unit and range:

    amplitude_m: float = quantity(0.5, "m", 0.01, 5.0)

A section converts and checks its values when it is built, from Python as from YAML: lists and
arrays become tuples, paths strings, and mappings sections. Errors name the dotted key, the unit,
the range and the nearest valid name. For a field whose type is a union of sections, the key
`kind` of a mapping selects the class. A tuple of such a union is a list of mappings.
"""

import dataclasses
import math
import types
import typing
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

from aerodrake.scenario.renamed import successor
from aerodrake.scenario.values import MAX_LIST, boolean, number, numbers, plain, string
from aerodrake.support.errors import ScenarioError, nearest, show
from aerodrake.support.files import is_packaged


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


class Section:
    """Base of the sections of a scenario: frozen dataclasses whose values are always valid.

    Raises:
        ScenarioError: if a value has the wrong type, length or range.
    """

    key: ClassVar[str] = ""
    """Dotted key of the section in a scenario, for messages; see `assign_keys`."""

    def __post_init__(self) -> None:
        """Converts and checks all values."""
        for name in _declared(type(self)):
            value = convert_field(type(self), name, getattr(self, name), "", self.key)
            object.__setattr__(self, name, value)


class Kind(Section):
    """Base of sections of a union; their keyword `kind` is the value of that key."""

    kind: ClassVar[str]

    def __init_subclass__(cls, kind: str = ""):
        cls.kind = kind


def assign_keys(root: type[Section]) -> None:
    """Sets the dotted key of each class of sections in `root`; items of a list have `[]`."""
    for name, (hint, _) in _declared(root).items():
        element = _element(hint)
        for section in typing.get_args(element) or (element,):
            if issubclass(section, Section):
                section.key = _join(root.key, name) + "[]" * (element is not hint)
                assign_keys(section)


def union_fields(cls: type) -> set[str]:
    """Returns the names of the fields whose key `kind` selects their class."""
    fields = _declared(cls).items()
    return {name for name, (hint, _) in fields if isinstance(_element(hint), types.UnionType)}


def build(cls: type, data: object, source: object, key: str = "") -> Any:
    """Converts a mapping to the section `cls`.

    Args:
        cls: A subclass of `Section`.
        data: The mapping, as parsed from YAML.
        source: Named in errors: the file or option that `data` came from.
        key: Dotted key of `data` in the source.

    Returns:
        An instance of `cls`, with defaults for keys that are not in `data`.

    Raises:
        ScenarioError: on unknown or renamed keys, wrong types, lengths or ranges.
    """
    if not isinstance(data, Mapping):
        raise ScenarioError(source, key, f"expected a mapping of keys to values, got {show(data)}")
    for name in data:
        _check_name(cls, name, source, key)
    try:
        return cls(**data)
    except ScenarioError as error:
        own = error.key.removeprefix(cls.key).lstrip(".")
        raise ScenarioError(source, _join(key, own), error.args[2]) from None


def convert_field(cls: type, name: str, value: object, source: object, key: str = "") -> Any:
    """Converts the value of one field of the section `cls`.

    Args:
        cls: A subclass of `Section`.
        name: Name of the field.
        value: A plain value as parsed from YAML, an array, a path, or a section.
        source: Named in errors.
        key: Dotted key of the section in the source.

    Raises:
        ScenarioError: as for `build`.
    """
    _check_name(cls, name, source, key)
    hint, metadata = _declared(cls)[name]
    return _convert(hint, metadata, value, source, _join(key, name))


def as_mapping(config: Any) -> Any:
    """Returns a mapping of every key of `config`, defaults included: the inverse of `build`."""
    if isinstance(config, Section):
        data = {name: as_mapping(getattr(config, name)) for name in _declared(type(config))}
        return {"kind": config.kind, **data} if isinstance(config, Kind) else data
    if isinstance(config, dict):
        return {name: as_mapping(value) for name, value in config.items()}
    return [as_mapping(value) for value in config] if isinstance(config, tuple) else config


def flat(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Returns the values of nested mappings by dotted key."""
    values: dict[str, Any] = {}
    for name, value in data.items():
        key = f"{prefix}{name}"
        values |= flat(value, f"{key}.") if isinstance(value, dict) else {key: value}
    return values


def map_files(config: Any, change: typing.Callable[[Path], Path]) -> Any:
    """Returns `config` with `change` applied to every file that is not in the package.

    Args:
        config: A section, or a mapping of names to sections and other values.
        change: Function of the file's path.
    """
    if isinstance(config, dict):
        return {name: map_files(value, change) for name, value in config.items()}
    if not isinstance(config, Section):
        return config
    changes: dict[str, Any] = {}
    for name, (_, metadata) in _declared(type(config)).items():
        value = getattr(config, name)
        if metadata.get("file") and value and not is_packaged(value):
            changes[name] = str(change(Path(value)))
        else:
            changes[name] = map_files(value, change)
    changes = {name: new for name, new in changes.items() if new is not getattr(config, name)}
    return dataclasses.replace(config, **changes) if changes else config


class _Declared(NamedTuple):
    """Type and metadata of a field."""

    hint: Any
    metadata: Mapping[str, Any]


@cache
def _declared(cls: type) -> dict[str, _Declared]:
    """Returns the fields of a section by name, without `provenance`."""
    hints = typing.get_type_hints(cls)
    fields = [f for f in dataclasses.fields(cls) if "provenance" not in f.metadata]
    return {f.name: _Declared(hints[f.name], f.metadata) for f in fields}


def _element(hint: Any) -> Any:
    """Returns the type of the items of a list; that of another field itself."""
    return typing.get_args(hint)[0] if typing.get_origin(hint) is tuple else hint


def _check_name(cls: type, name: object, source: object, key: str) -> None:
    if name not in _declared(cls):
        dotted = _join(key, str(name))
        kind = f" for kind {cls.kind}" if issubclass(cls, Kind) else ""
        advice = successor(dotted) or f"unknown key; {nearest(name, _declared(cls))}{kind}"
        raise ScenarioError(source, dotted, advice)


def _join(key: str, name: str) -> str:
    return f"{key}.{name}" if key and name else key or name


def _convert(hint: Any, meta: Mapping[str, Any], value: object, source: object, key: str) -> Any:
    value = plain(value)
    if isinstance(hint, types.UnionType):
        return _build_union(typing.get_args(hint), value, source, key)
    if dataclasses.is_dataclass(hint):
        if isinstance(value, Section):
            return _instance((hint,), value, source, key)
        return build(hint, value, source, key)
    if hint is bool:
        return boolean(value, source, key)
    if hint is str:
        return string(meta, value, source, key)
    if hint in (int, float):
        return number(hint, meta, value, source, key)
    element = typing.get_args(hint)[0]
    if not isinstance(element, types.UnionType):
        return numbers(element, meta, value, source, key)
    if not isinstance(value, list | tuple):
        raise ScenarioError(source, key, f"expected a list of mappings, got {show(value)}")
    if len(value) > MAX_LIST:
        raise ScenarioError(source, key, f"expected at most {MAX_LIST} items, got {len(value)}")
    kinds = typing.get_args(element)
    return tuple(_build_union(kinds, v, source, f"{key}[{i}]") for i, v in enumerate(value))


def _build_union(options: tuple[type, ...], value: object, source: object, key: str) -> Any:
    if isinstance(value, Section):
        return _instance(options, value, source, key)
    kinds = {option.kind: option for option in options}
    kind = value.get("kind") if isinstance(value, Mapping) else None
    if kind is None:
        raise ScenarioError(source, key, f"expected a mapping with a kind; {nearest('', kinds)}")
    if not isinstance(kind, str) or kind not in kinds:
        message = f"unknown kind {show(kind)}; {nearest(kind, kinds)}"
        raise ScenarioError(source, f"{key}.kind", message)
    return build(kinds[kind], {k: v for k, v in value.items() if k != "kind"}, source, key)


def _instance(options: tuple[type, ...], value: Section, source: object, key: str) -> Section:
    """Returns a section that was built in Python, after a check of its class."""
    if isinstance(value, options):
        return value
    names = " or ".join(option.__name__ for option in options)
    raise ScenarioError(source, key, f"expected {names}, got {show(value)}")
