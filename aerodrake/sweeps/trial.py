"""One flight of a sweep, and the row that tells of it."""

from __future__ import annotations

import os
import shlex
import socket
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import failure, repeatable, summarize
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import override
from aerodrake.scenario.plain_yaml import dump_line
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.support.threads import single_thread

FAILURES = ("failed", "refused")
"""What a row's `exit_reason` is where there was no flight: its process died or raised, or the
values do not make a scenario."""


@dataclass(frozen=True)
class Trial:
    """One flight of a sweep: what `aerodrake run SCENARIO` flies with these options.

    Attributes:
        index: Of the trial, from 0.
        seed: Of its scenario.
        parameters: The values of the keys that the sweep varies, by key.
        scenario: What all trials have in common.
    """

    index: int
    seed: int
    parameters: Mapping[str, Any]
    scenario: Scenario

    def overrides(self) -> list[tuple[str, str]]:
        """The options and assignments, as `load_scenario` takes them."""
        keys = [f"{key}={dump_line(v)}" for key, v in self.parameters.items() if key != "seed"]
        return [*(("--set", assignment) for assignment in keys), ("--seed", f"seed={self.seed}")]

    def resolved(self) -> Scenario:
        """The scenario that is flown.

        Raises:
            ScenarioError: if the values do not make one.
        """
        return override(self.scenario, self.overrides())

    def command(self, scenario: Path) -> str:
        """What flies this trial alone, for a shell.

        Args:
            scenario: The sweep's `scenario.yaml`.
        """
        words = ["aerodrake", "run", str(scenario)]
        for option, assignment in self.overrides():
            words += [
                option,
                assignment.removeprefix("seed=") if option == "--seed" else assignment,
            ]
        return shlex.join(words)

    def head(self) -> dict[str, Any]:
        """What a row begins with, however the flight ends."""
        return {"trial": self.index, "seed": self.seed, "parameters": dict(self.parameters)}


def fly_trial(trial: Trial) -> tuple[dict[str, Any], dict[str, Any]]:
    """Flies a trial.

    Returns:
        Its row: index, seed and parameters, then the figures of `summary.json` that
        are the same whenever it is flown, or `exit_reason` and `exit_cause` alone
        where there was no flight. And its timing: `trial`, `wall_s`, `host`, `process`.

    Raises:
        Exception: what is of the machine, not of the trial: no room on disk or in memory, say.
    """
    start = time.perf_counter()
    try:
        scenario = trial.resolved()
        with single_thread():
            figures = repeatable(summarize(scenario, FlightSimulation(scenario).fly()))
        ending = {k: v for k, v in figures.items() if k not in ("scenario", "seed", "version")}
    except (Exception, SystemExit) as error:  # Drake's conditions are the latter.
        if _is_of_machine(error):
            raise
        # Without the source, which is where the sweep's folder happens to be.
        ending = refusal(error) if isinstance(error, ScenarioError) else failure(error)
    timing = {
        "trial": trial.index,
        "wall_s": round(time.perf_counter() - start, 6),
        "host": socket.gethostname(),
        "process": os.getpid(),
    }
    return {**trial.head(), **ending}, timing


def _is_of_machine(error: BaseException) -> bool:
    """Whether it began with what the machine refused, as much bad input does.

    That the scenario names a file which is not there is its own.
    """
    began: BaseException | None = error
    while began is not None and not isinstance(began, OSError | MemoryError):
        began = began.__context__
    is_missing = isinstance(error, ScenarioError) and isinstance(began, FileNotFoundError)
    return began is not None and not is_missing


def refusal(error: BadInput) -> dict[str, str]:
    """What stands for the figures of a trial whose values do not make a scenario."""
    said = str(type(error)("", *error.args[1:]))
    return {"exit_reason": "refused", "exit_cause": said}
