"""Whether the sweep that a folder holds is the one that is asked for."""

from __future__ import annotations

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
"""The files that tell what is flown; the scenario's own are beside them."""

MAX_BYTES = 10_000_000


def check_same(target: Path, plan: Plan) -> None:
    """Whether the sweep in a folder is that of a plan, but for more trials.

    Args:
        target: The sweep's folder.
        plan: What is asked for.

    Raises:
        BadInput: if it is none, or another one: with the first key that differs.
        OSError: if it cannot be read.
    """
    found = _read_plan(target)
    ours = _flat(found) | {"vary": _grid(found["vary"])}
    with tempfile.TemporaryDirectory() as temporary:
        asked = Path(temporary)
        save_scenario(plan.scenario, asked)
        ours = _described(target) | ours
        wanted = {**plan.as_mapping(), "vary": plan.vary}
        theirs = _described(asked) | _flat(wanted) | {"vary": _grid(plan.vary)}
        files = {p.relative_to(f) for f in (target, asked) for p in f.glob("inputs*/**/*")}
        for file in sorted(files):
            if not all((f / file).is_dir() for f in (target, asked)):
                ours[str(file)], theirs[str(file)] = (_content(f / file) for f in (target, asked))
    if ours["trials"] < theirs["trials"]:
        del ours["trials"], theirs["trials"]
    for key in {**ours, **theirs}:
        if ours.get(key) != theirs.get(key):
            mine, asked_for = (_shown(values.get(key)) for values in (ours, theirs))
            message = f"the sweep in {target} has {mine}, not {asked_for}"
            raise BadInput("--resume", key, message)


def _grid(vary: Mapping[str, Distribution]) -> list[str]:
    """The keys of a grid, whose order is that of its trials."""
    return [key for key, distribution in vary.items() if isinstance(distribution, Linspace)]


def _read_plan(target: Path) -> dict[str, Any]:
    """With the distributions themselves, which can be written in more than one way."""
    path = target / PLAN
    if not path.is_file():
        raise BadInput("--resume", "", f"{target} holds no sweep")
    try:
        plan = json.loads(read_bounded(path, MAX_BYTES))
        if isinstance(plan["trials"], int):
            vary = {key: parse_distribution(text, key) for key, text in plan["vary"].items()}
            return {**plan, "vary": vary}
    except (BadInput, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise BadInput(path, "", "expected the plan of a sweep")


def _described(folder: Path) -> dict[str, Any]:
    content = read_bounded(folder / SCENARIO, MAX_BYTES)
    described = parse(content.decode(errors="replace"), folder / SCENARIO)
    if not isinstance(described, dict):
        raise BadInput(folder / SCENARIO, "", "expected the scenario of a sweep")
    return _flat(described)


def _flat(data: dict[str, Any], prefix: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            found |= _flat(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = value
    return found


def _content(file: Path) -> str:
    """Told by its SHA-256."""
    if not file.is_file():
        return "no such file"
    return f"content {hashlib.sha256(file.read_bytes()).hexdigest()[:16]}"


def _shown(value: Any) -> str:
    return "none" if value is None else f"{value}"[:60]
