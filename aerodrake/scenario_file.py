"""Scenario files: found by name or path, overridden, checked, and written."""

from __future__ import annotations

import dataclasses
import os
import shutil
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import yaml
from pydrake.common.yaml import yaml_dump, yaml_load_data

from aerodrake.errors import BadInput, nearest
from aerodrake.scenario import Scenario
from aerodrake.scenario_rules import check
from aerodrake.schema import as_mapping, build, map_files

MAX_FILE_BYTES = 100_000
"""A scenario file is never larger: a guard against hostile input."""


def packaged_scenarios() -> dict[str, Path]:
    """The scenarios that come with aerodrake, by name."""
    folder = Path(str(resources.files("aerodrake") / "scenarios"))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def load_scenario(name_or_path: str, overrides: Iterable[tuple[str, str]] = ()) -> Scenario:
    """Reads and checks a scenario.

    Args:
        name_or_path: The name of a packaged scenario, or the path of a YAML file.
        overrides: Pairs of the option as it was typed, which errors name, and
            its `dotted.key=value`, applied in order on top of the file. Paths
            in them are relative to the working directory; those in the file
            are relative to the file.

    Raises:
        BadInput: if the scenario is missing, unreadable or invalid.
    """
    path = _find(name_or_path)
    data = _parse(_read(path), path)
    if not isinstance(data, Mapping) or not data:
        found = "" if data else ", got an empty file"
        raise BadInput(path, "", f"expected a mapping of scenario keys to values{found}")
    scenario = map_files(build(Scenario, data, path), lambda file: path.parent.resolve() / file)
    source = str(path)
    for option, assignment in overrides:
        scenario = _override(scenario, option, assignment)
        source += f" {option} {assignment.removeprefix(option.removeprefix('--') + '=')}"
    scenario = map_files(scenario, Path.absolute)
    check(scenario, source)
    return dataclasses.replace(scenario, name=scenario.name or path.stem, source=source)


def save_scenario(scenario: Scenario, folder: Path) -> Path:
    """Writes `scenario.yaml`, and a copy of each file it refers to, into `folder`.

    What is written is complete and does not depend on the original's place:
    running it again gives the same flight. Only a robot of your own stays
    where it is, with its meshes.
    """

    def copy(file: Path) -> Path:
        place = Path("inputs", file.name)
        while (folder / place).exists():
            place = place.with_name(f"other_{place.name}")
        (folder / place).parent.mkdir(exist_ok=True)
        shutil.copyfile(file, folder / place)
        return place

    vehicle = scenario.vehicle  # The robot stays where its meshes are.
    portable = dataclasses.replace(
        map_files(
            dataclasses.replace(scenario, vehicle=dataclasses.replace(vehicle, robot="")), copy
        ),
        vehicle=vehicle,
    )
    path = folder / "scenario.yaml"
    path.write_text(yaml_dump(as_mapping(portable)), encoding="utf-8")
    return path


def _find(name_or_path: str) -> Path:
    packaged = packaged_scenarios()
    if name_or_path in packaged:
        return packaged[name_or_path]
    path = Path(name_or_path)
    if path.suffix in (".yaml", ".yml") or os.sep in name_or_path:
        return path
    raise BadInput(
        name_or_path,
        "",
        f"no such scenario; {nearest(name_or_path, packaged)} or the path of a .yaml file",
    )


def _read(path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
        if len(content) > MAX_FILE_BYTES:
            raise BadInput(path, "", f"expected a scenario of at most {MAX_FILE_BYTES} bytes")
        return content.decode("utf-8")
    except OSError as error:
        raise BadInput(path, "", f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise BadInput(path, "", "expected UTF-8 text") from None
    except ValueError as error:  # A path with a NUL in it.
        raise BadInput(path, "", f"cannot be read: {error}") from None


def _parse(text: str, source: object) -> Any:
    try:
        _check_node(yaml.compose(text, Loader=yaml.SafeLoader), source, set())
        return yaml_load_data(text, private=True)
    except yaml.MarkedYAMLError as error:
        line = f"line {error.problem_mark.line + 1}: " if error.problem_mark else ""
        raise BadInput(source, "", f"expected YAML; {line}{error.problem}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise BadInput(source, "", f"expected YAML; {error}") from None


def _check_node(node: yaml.Node | None, source: object, seen: set[int]) -> None:
    """Refuses what YAML would take in silence: aliases, merges, keys twice or no names."""
    if id(node) in seen:
        line = node.start_mark.line + 1
        raise BadInput(source, "", f"line {line}: expected no aliases; write the value out")
    seen.add(id(node))
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _check_node(item, source, seen)
    elif isinstance(node, yaml.MappingNode):
        names = set()
        for key, value in node.value:
            name = str(key.value)
            line = f"line {key.start_mark.line + 1}"
            if key.tag != "tag:yaml.org,2002:str":
                raise BadInput(source, "", f"{line}: expected a name as key, got {name}")
            if name in names:
                raise BadInput(source, name, f"{line}: expected each key once")
            names.add(name)
            _check_node(value, source, seen)


def _override(scenario: Scenario, option: str, assignment: str) -> Scenario:
    key, equals, text = assignment.partition("=")
    if not equals or not key:
        raise BadInput(option, "", f"expected dotted.key=value, got '{assignment}'")
    value = _parse(text, option)
    data = as_mapping(scenario)
    node = data
    *parents, leaf = key.split(".")
    for depth, name in enumerate(parents):
        if not isinstance(node.get(name), dict):
            sections = [k for k, v in node.items() if isinstance(v, dict)]
            raise BadInput(
                option,
                ".".join(parents[: depth + 1]),
                f"unknown section; {nearest(name, sections)}",
            )
        node = node[name]
    if key in ("reference.kind", "orientation.kind") and node.get("kind") != value:
        node.clear()  # Another kind has keys of its own.
    node[leaf] = value
    return build(Scenario, data, option)
