"""Overrides of single keys of a scenario, from Python values or from the command line's text."""

import re
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from aerodrake.scenario.plain_yaml import parse
from aerodrake.scenario.renamed import successor
from aerodrake.scenario.scenario import Scenario
from aerodrake.scenario.schema import as_mapping, convert_field, union_fields
from aerodrake.support.errors import BadInput, ScenarioError, nearest, show


class Override(NamedTuple):
    """New value of one key.

    Attributes:
        source: Named in errors: a scenario, or an option of the command line.
        key: Dotted key; `key[0]` is the first element of a list.
        value: A plain value, an array, a path or a section.
    """

    source: object
    key: str
    value: Any


def from_option(option: str, assignment: str) -> Override:
    """Returns the override that an option of the command line assigns.

    Args:
        option: The option, named in errors.
        assignment: `dotted.key=value`, with the value in YAML.

    Raises:
        ScenarioError: if the text is no assignment, or its value is not plain YAML.
    """
    key, equals, text = assignment.partition("=")
    if not equals or not key:
        raise ScenarioError(option, "", f"expected dotted.key=value, got '{assignment}'")
    return Override(option, key, parse(text, option, key))


def from_keys(
    source: object, overrides: Mapping[str, Any] | None, keys: Mapping[str, Any]
) -> list[Override]:
    """Returns the overrides of a mapping and of keyword arguments.

    A key comes after those that contain it, and after the `kind` that it may depend on.

    Args:
        source: The scenario, named in errors.
        overrides: Values by dotted key.
        keys: The same, after `overrides`.

    Raises:
        BadInput: if `overrides` is not a mapping of strings.
    """
    if not isinstance(overrides, Mapping | None):
        expected = "expected a mapping of dotted keys to values"
        raise BadInput(source, "overrides", f"{expected}, got {show(overrides)}")
    for key in overrides or ():
        if not isinstance(key, str):
            raise BadInput(source, "overrides", f"expected dotted keys, got {show(key)}")
    changes = [*(overrides or {}).items(), *keys.items()]
    changes.sort(key=lambda change: (len(_parts(change[0])), not change[0].endswith(".kind")))
    return [Override(source, key, value) for key, value in changes]


def apply(sections: Mapping[str, Any], overrides: Iterable[Override]) -> dict[str, Any]:
    """Returns the fields of a scenario with overridden keys, each of which is valid by itself.

    Args:
        sections: Values of the fields of `Scenario` by name.
        overrides: Applied in order.

    Raises:
        ScenarioError: if a key does not exist, or a value is invalid.
    """
    changed = dict(sections)
    for override in overrides:
        name, data = _assign(changed, override)
        changed[name] = convert_field(Scenario, name, data, override.source)
    return changed


def _assign(sections: Mapping[str, Any], override: Override) -> tuple[str, Any]:
    """Returns the name of the field that has the key, and the field's plain data with it set."""
    source, key, value = override
    data = node = as_mapping(dict(sections))
    *parents, leaf = key.split(".")
    for depth, name in enumerate(parents):
        children = _mappings(node)
        if name not in children:
            section = ".".join(parents[: depth + 1])
            advice = successor(section) or f"unknown section; {_sections(node, name, children)}"
            raise ScenarioError(source, section, advice)
        node = children[name]
    field = re.split(r"[.\[]", key, maxsplit=1)[0]
    if field in union_fields(Scenario) and leaf == "kind" and node.get("kind") != value:
        node.clear()  # Each kind has its own keys.
    element = re.fullmatch(r"(\w+)\[([0-9]{1,4})\]", leaf)
    if element and isinstance(node.get(element[1]), list):
        values, index = node[element[1]], int(element[2])
        if index >= len(values):
            list_key = key.removesuffix(f"[{element[2]}]")
            message = f"expected an index below {len(values)}, got [{index}]"
            raise ScenarioError(source, list_key, message)
        values[index] = value
    else:
        node[leaf] = value
    name = field if field in sections else key
    return name, data[name]


def _sections(node: dict[str, Any], name: str, valid: Iterable[str]) -> str:
    """Returns a clause on the sections of a mapping that has none of this name."""
    field = name.partition("[")[0]
    if isinstance(node.get(field), list):
        return f"{field} is a list of {len(node[field])}, whose first item is {field}[0]"
    return f"{name} is a value" if name in node else nearest(name, valid)


def _mappings(node: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Returns the mappings in `node` by name; those in a list as `faults[0]`, `faults[1]`, ..."""
    mappings = {name: value for name, value in node.items() if isinstance(value, dict)}
    for name, value in node.items():
        if isinstance(value, list):
            entries = {f"{name}[{i}]": entry for i, entry in enumerate(value)}
            mappings |= {key: entry for key, entry in entries.items() if isinstance(entry, dict)}
    return mappings


def _parts(key: str) -> list[str]:
    return key.replace("[", ".[").split(".")
