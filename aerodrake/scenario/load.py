"""Loading, overriding, checking and saving of scenarios."""

import dataclasses
import os
import re
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from aerodrake.scenario.inputs import copy_inputs
from aerodrake.scenario.plain_yaml import dump, parse
from aerodrake.scenario.renamed import successor
from aerodrake.scenario.rules import MAX_NAME_BYTES, check
from aerodrake.scenario.schema import as_mapping, build, map_files
from aerodrake.scenario.sections import Scenario
from aerodrake.support.errors import BadInput, ScenarioError, nearest
from aerodrake.support.files import read_bounded

UNIONS = ("reference", "orientation", "faults")
"""Sections whose key `kind` selects their class."""

MAX_FILE_BYTES = 100_000
"""Largest size of a scenario file; protects against hostile input."""


def packaged_scenarios() -> dict[str, Path]:
    """Returns the paths of the packaged scenarios by name."""
    folder = Path(str(resources.files("aerodrake") / "scenarios"))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def load_scenario(name_or_path: str, overrides: Iterable[tuple[str, str]] = ()) -> Scenario:
    """Reads and checks a scenario.

    Args:
        name_or_path: The name of a packaged scenario, or the path of a YAML file.
        overrides: Pairs of an option, which errors name, and its `dotted.key=value`,
            applied in order on top of the file. Paths in overrides are relative to the
            working directory, paths in the file are relative to the file.

    Raises:
        ScenarioError: if the scenario is missing, unreadable or invalid.
    """
    path = _find(name_or_path)
    data = parse(_read(path), path)
    if not isinstance(data, Mapping) or not data:
        got = "" if data else ", got an empty file"
        raise ScenarioError(path, "", f"expected a mapping of scenario keys to values{got}")
    scenario = map_files(build(Scenario, data, path), lambda file: path.parent.resolve() / file)
    scenario = dataclasses.replace(scenario, name=scenario.name or _name(path), source=str(path))
    return override(scenario, overrides)


def override(scenario: Scenario, overrides: Iterable[tuple[str, str]]) -> Scenario:
    """Returns the scenario with overridden keys, after checking that all keys are consistent.

    Args:
        scenario: A scenario from `load_scenario`.
        overrides: As for `load_scenario`.

    Raises:
        ScenarioError: if a key or value is invalid, or keys are inconsistent.
    """
    source, name = scenario.source, scenario.name
    for option, assignment in overrides:
        scenario = set_key(scenario, option, assignment)
        source += f" {option} {assignment.removeprefix(option.removeprefix('--') + '=')}"
    scenario = map_files(scenario, Path.absolute)
    check(scenario, source)
    return dataclasses.replace(scenario, name=scenario.name or name, source=source)


def save_scenario(scenario: Scenario, folder: Path) -> Path:
    """Writes `scenario.yaml`, and a copy of each file that it names, into `folder`.

    The folder is self-contained: running its scenario gives the same flight.

    Raises:
        OSError: if a file cannot be written.
    """

    def relative(file: Path) -> Path:
        return file.relative_to(folder) if file.is_relative_to(folder) else file

    portable = map_files(copy_inputs(scenario, folder / "inputs"), relative)
    path = folder / "scenario.yaml"
    path.write_text(dump(as_mapping(portable)), encoding="utf-8")
    return path


def _find(name_or_path: str) -> Path:
    packaged = packaged_scenarios()
    if name_or_path in packaged:
        return packaged[name_or_path]
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or os.sep in name_or_path:
        return path
    raise ScenarioError(
        name_or_path,
        "",
        f"no such scenario; {nearest(name_or_path, packaged)} or the path of a .yaml file",
    )


def _name(path: Path) -> str:
    """Returns the file's name without characters that a folder's name must not have."""
    stem = "".join(c if c.isprintable() and c not in "/\\" else "_" for c in path.stem)
    return stem.lstrip(".").encode()[:MAX_NAME_BYTES].decode(errors="ignore") or "scenario"


def _read(path: Path) -> str:
    try:
        return read_bounded(path, MAX_FILE_BYTES).decode("utf-8")
    except BadInput as error:
        raise ScenarioError(*error.args) from None
    except UnicodeDecodeError as error:
        raise ScenarioError(path, "", f"expected UTF-8 text; byte {error.start} is not") from None


def set_key(scenario: Scenario, option: str, assignment: str) -> Scenario:
    """Returns the scenario with one key changed, without checking its consistency with others.

    Args:
        scenario: The scenario to change.
        option: The option named in errors.
        assignment: `dotted.key=value`; `key[0]` is the first element of a list.

    Raises:
        ScenarioError: if the key does not exist, or the value is invalid.
    """
    key, equals, text = assignment.partition("=")
    if not equals or not key:
        raise ScenarioError(option, "", f"expected dotted.key=value, got '{assignment}'")
    value = parse(text, option, key)
    data = as_mapping(scenario)
    node = data
    *parents, leaf = key.split(".")
    for depth, name in enumerate(parents):
        sections = _sections(node)
        if name not in sections:
            section = ".".join(parents[: depth + 1])
            advice = successor(section) or f"unknown section; {nearest(name, sections)}"
            raise ScenarioError(option, section, advice)
        node = sections[name]
    is_union = key.partition(".")[0].partition("[")[0] in UNIONS
    if is_union and leaf == "kind" and node.get("kind") != value:
        node.clear()  # Each kind has its own keys.
    element = re.fullmatch(r"(\w+)\[([0-9]{1,4})\]", leaf)
    if element and isinstance(node.get(element[1]), list):
        values, index = node[element[1]], int(element[2])
        if index >= len(values):
            list_key = key.removesuffix(f"[{element[2]}]")
            message = f"expected an index below {len(values)}, got [{index}]"
            raise ScenarioError(option, list_key, message)
        values[index] = value
    else:
        node[leaf] = value
    return build(Scenario, data, option)


def _sections(node: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Returns the mappings in `node` by name; those in a list as `faults[0]`, `faults[1]`, ..."""
    sections = {name: value for name, value in node.items() if isinstance(value, dict)}
    for name, value in node.items():
        if isinstance(value, list):
            entries = {f"{name}[{i}]": entry for i, entry in enumerate(value)}
            sections |= {key: entry for key, entry in entries.items() if isinstance(entry, dict)}
    return sections
