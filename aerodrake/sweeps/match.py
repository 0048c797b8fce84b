"""Comparison of the sweep in a folder with a plan, before it is resumed."""

import hashlib
import json
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aerodrake.scenario.load import save_scenario
from aerodrake.scenario.plain_yaml import parse
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded
from aerodrake.sweeps.distributions import Distribution, Linspace, parse_distribution
from aerodrake.sweeps.plan import Plan

SCENARIO, PLAN = "scenario.yaml", "sweep.json"
"""Files that define a sweep, beside the files that the scenario names."""

MAX_BYTES = 10_000_000


def check_same(target: Path, plan: Plan) -> None:
    """Checks that a folder contains the sweep of a plan, which may have more trials.

    Args:
        target: Folder of the sweep.
        plan: Plan to compare with.

    Raises:
        BadInput: if the folder contains no sweep, or another one: with the first key that differs.
        OSError: if the folder cannot be read.
    """
    stored = _read_plan(target)
    ours = _flat(stored) | {"vary": _grid(stored["vary"])}
    with tempfile.TemporaryDirectory() as temporary:
        saved = Path(temporary)
        save_scenario(plan.scenario, saved)
        ours = _read_scenario(target) | ours
        mapping = {**plan.as_mapping(), "vary": plan.vary}
        theirs = _read_scenario(saved) | _flat(mapping) | {"vary": _grid(plan.vary)}
        files = {p.relative_to(f) for f in (target, saved) for p in f.glob("inputs*/**/*")}
        for file in sorted(files):
            if not all((f / file).is_dir() for f in (target, saved)):
                ours[str(file)], theirs[str(file)] = (_content(f / file) for f in (target, saved))
    if ours["trials"] < theirs["trials"]:
        del ours["trials"], theirs["trials"]
    for key in {**ours, **theirs}:
        if ours.get(key) != theirs.get(key):
            own, other = (_shown(values.get(key)) for values in (ours, theirs))
            raise BadInput("--resume", key, f"the sweep in {target} has {own}, not {other}")


def _grid(vary: Mapping[str, Distribution]) -> list[str]:
    """Returns the keys of a grid, whose order determines that of the trials."""
    return [key for key, distribution in vary.items() if isinstance(distribution, Linspace)]


def _read_plan(target: Path) -> dict[str, Any]:
    """Returns the plan with parsed distributions, since their notation is not unique."""
    path = target / PLAN
    if not path.is_file():
        raise BadInput("--resume", "", f"{target} contains no sweep")
    try:
        plan = json.loads(read_bounded(path, MAX_BYTES))
        if isinstance(plan["trials"], int):
            vary = {key: parse_distribution(text, key) for key, text in plan["vary"].items()}
            return {**plan, "vary": vary}
    except (BadInput, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise BadInput(path, "", "expected the plan of a sweep")


def _read_scenario(folder: Path) -> dict[str, Any]:
    content = read_bounded(folder / SCENARIO, MAX_BYTES)
    scenario = parse(content.decode(errors="replace"), folder / SCENARIO)
    if not isinstance(scenario, dict):
        raise BadInput(folder / SCENARIO, "", "expected the scenario of a sweep")
    return _flat(scenario)


def _flat(data: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    """Returns the values of nested mappings by dotted key."""
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat |= _flat(value, f"{prefix}{key}.")
        else:
            flat[f"{prefix}{key}"] = value
    return flat


def _content(file: Path) -> str:
    """Returns a label of a file's content, from its SHA-256."""
    if not file.is_file():
        return "no such file"
    return f"content {hashlib.sha256(file.read_bytes()).hexdigest()[:16]}"


def _shown(value: Any) -> str:
    return "none" if value is None else f"{value}"[:60]
