"""One flight of a sweep, and its row."""

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
from aerodrake.support.errors import ScenarioError
from aerodrake.support.threads import single_thread

FAILURES = ("failed", "refused")
"""Exit reasons of rows without a flight: the process died or raised; the values are invalid."""


@dataclass(frozen=True)
class Trial:
    """One flight of a sweep, as its `command` flies it alone.

    Attributes:
        index: Index, from 0.
        seed: Seed of the trial's scenario.
        parameters: Values of the varied keys.
        scenario: Scenario that all trials share.
    """

    index: int
    seed: int
    parameters: Mapping[str, Any]
    scenario: Scenario

    def resolved(self) -> Scenario:
        """Returns the scenario of the trial.

        Raises:
            ScenarioError: if the values are invalid.
        """
        return override(self.scenario, {**self.parameters, "seed": self.seed})

    def command(self, scenario: Path) -> str:
        """Returns the shell command that flies this trial alone; `scenario` is the sweep's file."""
        keys = [f"{key}={dump_line(v)}" for key, v in self.parameters.items() if key != "seed"]
        words = [word for assignment in keys for word in ("--set", assignment)]
        again = ["aerodrake", "run", str(scenario), *words, "--seed", str(self.seed)]
        return shlex.join(again)

    def header(self) -> dict[str, Any]:
        """Returns the first entries of the row, which do not depend on the flight."""
        return {"trial": self.index, "seed": self.seed, "parameters": dict(self.parameters)}


def fly_trial(trial: Trial) -> tuple[dict[str, Any], dict[str, Any]]:
    """Flies a trial.

    Returns:
        Row: index, seed and parameters, then the entries of `summary.json` that are repeatable,
        or `exit_reason` and `exit_cause` alone if there was no flight. Timing: `trial`,
        `wall_s`, `host`, `process`.

    Raises:
        Exception: an error of the machine, not of the trial, such as a full disk or memory.
    """
    start = time.perf_counter()
    try:
        scenario = trial.resolved()
        with single_thread():
            figures = repeatable(summarize(scenario, FlightSimulation(scenario).fly()))
        ending = {k: v for k, v in figures.items() if k not in ("scenario", "seed", "version")}
    except (Exception, SystemExit) as error:  # Drake raises SystemExit.
        if _is_machine_error(error):
            raise
        ending = failure(error)
        if isinstance(error, ScenarioError):
            # Without the source, which depends on the path of the sweep's folder.
            message = str(type(error)("", *error.args[1:]))
            ending = {"exit_reason": "refused", "exit_cause": message}
    timing = {
        "trial": trial.index,
        "wall_s": round(time.perf_counter() - start, 6),
        "host": socket.gethostname(),
        "process": os.getpid(),
    }
    return {**trial.header(), **ending}, timing


def _is_machine_error(error: BaseException) -> bool:
    """Returns True if the first cause of an error is the operating system.

    A missing file that the scenario names is an error of the scenario.
    """
    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, OSError | MemoryError):
        cause = cause.__context__
    is_missing = isinstance(error, ScenarioError) and isinstance(cause, FileNotFoundError)
    return cause is not None and not is_missing
