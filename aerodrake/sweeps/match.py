"""Comparison of the sweep in a folder with a plan, before it is resumed."""

import hashlib
import json
import tempfile
from pathlib import Path
from typing import Any

from aerodrake.scenario.load import save_scenario
from aerodrake.scenario.plain_yaml import parse
from aerodrake.scenario.schema import flat
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded
from aerodrake.sweeps.distributions import Linspace, parse_distribution
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import SCENARIO, StudyFiles

MAX_BYTES = 10_000_000


def check_same(target: Path, plan: Plan) -> None:
    """Checks that the folder `target` contains the sweep of a plan, which may have more trials.

    Raises:
        BadInput: if the folder contains no sweep, or another one: with the first key that differs.
        OSError: if the folder cannot be read.
    """
    stored = _values(target, _read_plan(target, plan.files))
    with tempfile.TemporaryDirectory() as temporary:
        saved = Path(temporary)
        save_scenario(plan.scenario, saved)
        expected = _values(saved, {**plan.as_mapping(), "vary": plan.vary})
        files = {p.relative_to(f) for f in (target, saved) for p in f.glob("inputs*/**/*")}
        for file in sorted(files):
            if not all((f / file).is_dir() for f in (target, saved)):
                stored[str(file)], expected[str(file)] = _content(target / file, saved / file)
    if stored["trials"] < expected["trials"]:
        del stored["trials"], expected["trials"]
    for key in {**stored, **expected}:
        if stored.get(key) != expected.get(key):
            one, other = (f"{values.get(key, 'none')}"[:60] for values in (stored, expected))
            raise BadInput(
                "resume", key, f"the {plan.files.kind} in {target} has {one}, not {other}"
            )


def _values(folder: Path, plan: dict[str, Any]) -> dict[str, Any]:
    """Returns the values of scenario and plan by dotted key.

    `vary` has the keys of the grid, whose order determines that of the trials.
    """
    content = read_bounded(folder / SCENARIO, MAX_BYTES)
    scenario = parse(content.decode(errors="replace"), folder / SCENARIO)
    if not isinstance(scenario, dict):
        raise BadInput(folder / SCENARIO, "", "expected the scenario of a sweep")
    grid = [key for key, distribution in plan["vary"].items() if isinstance(distribution, Linspace)]
    return flat(scenario) | flat(plan) | {"vary": grid}


def _read_plan(target: Path, files: StudyFiles) -> dict[str, Any]:
    """Returns the plan with parsed distributions, since their notation is not unique."""
    path = target / files.plan
    if not path.is_file():
        raise BadInput("resume", "", f"{target} contains no {files.kind}")
    try:
        plan = json.loads(read_bounded(path, MAX_BYTES))
        if isinstance(plan["trials"], int):
            vary = {key: parse_distribution(text, key) for key, text in plan["vary"].items()}
            return {**plan, "vary": vary}
    except (BadInput, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    raise BadInput(path, "", f"expected the plan of a {files.kind}")


def _content(*files: Path) -> list[str]:
    """Returns a label of each file's content, from its SHA-256."""
    return [
        f"content {hashlib.sha256(file.read_bytes()).hexdigest()[:16]}"
        if file.is_file()
        else "no such file"
        for file in files
    ]
