"""Loading, overriding, checking and saving of scenarios."""

import os
from collections.abc import Iterable, Mapping
from importlib import resources
from pathlib import Path
from typing import Any

from aerodrake.scenario.inputs import copy_inputs
from aerodrake.scenario.overrides import Override, apply, from_keys, from_option
from aerodrake.scenario.plain_yaml import dump, parse
from aerodrake.scenario.scenario import MAX_NAME_BYTES, Scenario
from aerodrake.scenario.schema import as_mapping, convert_field, map_files
from aerodrake.support.errors import BadInput, ScenarioError, nearest, show, sourced
from aerodrake.support.files import read_bounded

MAX_FILE_BYTES = 100_000
"""Largest size of a scenario file; protects against hostile input."""


def packaged_scenarios() -> dict[str, Path]:
    """Returns the paths of the packaged scenarios by name."""
    folder = Path(str(resources.files("aerodrake") / "scenarios"))
    return {path.stem: path for path in sorted(folder.glob("*.yaml"))}


def load_scenario(
    name_or_path: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None, **keys: Any
) -> Scenario:
    """Reads and checks a scenario.

        load_scenario("clover", duration=3)
        load_scenario("clover", {"mpc.horizon": 10, "wind": Wind(velocity_m_s=(2, 0, 0))})

    Args:
        name_or_path: The name of a packaged scenario, or the path of a YAML file.
        overrides: Values by dotted key on top of the file: numbers, strings, lists, arrays, paths,
            mappings or sections. `key[0]` is the first element of a list. A mapping or section
            replaces the whole section. Paths are relative to the working directory, those in
            the file relative to the file.
        **keys: The same as keyword arguments.

    Raises:
        ScenarioError: if the scenario is missing, unreadable or invalid, with the dotted key.
    """
    if not isinstance(name_or_path, str | os.PathLike):
        expected = "expected the name of a packaged scenario or the path of a .yaml file"
        raise ScenarioError("name_or_path", "", f"{expected}, got {show(name_or_path)}")
    name = os.fspath(name_or_path)
    changes = from_keys(name, overrides, keys)
    path = _find(name)
    return _load(path, changes, name if changes else str(path))


def load_with_options(name_or_path: str, options: Iterable[tuple[str, str]]) -> Scenario:
    """Reads and checks a scenario with options of the command line.

    Args:
        name_or_path: As for `load_scenario`.
        options: Pairs of an option, which errors name, and its `dotted.key=value`, applied
            in order on top of the file.

    Raises:
        ScenarioError: as for `load_scenario`.
    """
    options = list(options)
    overrides = [from_option(*pair) for pair in options]
    path = _find(name_or_path)
    typed = " ".join([str(path), *(_words(*pair) for pair in options)])
    return _load(path, overrides, typed)


def override(
    scenario: Scenario, overrides: Mapping[str, Any] | None = None, **keys: Any
) -> Scenario:
    """Returns the scenario with overridden keys.

    Args:
        scenario: Any scenario.
        overrides: As for `load_scenario`.
        **keys: The same as keyword arguments.

    Raises:
        ScenarioError: if a key or value is invalid, or keys are inconsistent.
    """
    if not isinstance(scenario, Scenario):
        raise ScenarioError("scenario", "", f"expected Scenario, got {show(scenario)}")
    source = scenario.name or scenario.source
    return _changed(vars(scenario), from_keys(source, overrides, keys), scenario.name, source)


def resolve(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    **keys: Any,
) -> Scenario:
    """Returns a scenario, or one read from a name or path, with overridden keys.

    Args:
        scenario: A scenario, or as for `load_scenario`.
        overrides, keys: As for `load_scenario`.

    Raises:
        ScenarioError: as for `load_scenario`.
    """
    if isinstance(scenario, Scenario):
        return override(scenario, overrides, **keys) if overrides or keys else scenario
    return load_scenario(scenario, overrides, **keys)


def as_yaml(scenario: Scenario | Mapping[str, Any]) -> str:
    """Returns a scenario, or the values of its fields, as the text of a YAML file."""
    return dump(as_mapping(scenario))


def save_scenario(scenario: Scenario, folder: Path) -> Path:
    """Writes `scenario.yaml`, and a copy of each file that it names, into `folder`.

    The folder is self-contained: running its scenario gives the same flight.

    Raises:
        OSError: if a file cannot be written.
    """

    folder = folder.absolute()

    def relative(file: Path) -> Path:
        return file.relative_to(folder) if file.is_relative_to(folder) else file

    copied = copy_inputs(scenario, folder / "inputs")
    portable = {name: map_files(getattr(copied, name), relative) for name in as_mapping(copied)}
    path = folder / "scenario.yaml"
    path.write_text(as_yaml(portable), encoding="utf-8")
    return path


def _load(path: Path, overrides: Iterable[Override], source: str) -> Scenario:
    """Reads a scenario; `source` names it with its overrides in errors."""
    data = parse(_read(path), path)
    if not isinstance(data, Mapping) or not data:
        got = "" if data else ", got an empty file"
        raise ScenarioError(path, "", f"expected a mapping of scenario keys to values{got}")
    fields = {name: convert_field(Scenario, name, value, path) for name, value in data.items()}
    folder = path.parent.resolve()
    fields = map_files(fields, lambda file: folder / file)
    name = fields.get("name") or _name(path)
    return _changed({**vars(Scenario()), **fields}, overrides, name, source)


def _changed(
    fields: Mapping[str, Any], overrides: Iterable[Override], name: str, source: str
) -> Scenario:
    """Returns the scenario with overridden keys; an empty name is replaced by `name`."""
    changed = apply(fields, overrides)
    with sourced(source):
        return Scenario(**changed | {"name": changed["name"] or name, "source": source})


def _words(option: str, assignment: str) -> str:
    """Returns an option as it is typed: `--set key=value`, `--seed value`."""
    return f"{option} {assignment.removeprefix(option.removeprefix('--') + '=')}"


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
