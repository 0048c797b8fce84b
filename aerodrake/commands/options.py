"""Arguments, notes, folders and progress bars that several commands share."""

import argparse
import itertools
import math
import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_with_options
from aerodrake.scenario.rules import warnings

FLIGHT_BAR = (
    "{desc} {percentage:3.0f}%|{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}, {rate_fmt}]"
)
"""Format of a progress bar over simulated time."""

LIVE_BAR = "{desc} {n:.1f}/{total:.1f} s{postfix} |{bar}|"
"""Format of a progress bar with the flight's state; fits into 80 columns."""

LCM_URL = "udpm://239.255.76.67:7667?ttl=0"
"""LCM's default address, on this machine alone; ttl=1 includes the local network."""


def add_scenario(command: argparse.ArgumentParser, default: str = "") -> None:
    """Adds the scenario and the option that overrides its keys."""
    text = "name of a packaged scenario, or path of a YAML file"
    if default:
        text += f"; default: {default}"
        command.add_argument("scenario", nargs="?", default=default, help=text)
    else:
        command.add_argument("scenario", help=text)
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="override a dotted key of the scenario; may be given several times",
    )


def add_output(command: argparse.ArgumentParser, default: str) -> None:
    """Adds the folder of the results and the option not to print."""
    command.add_argument(
        "--out", type=Path, metavar="DIR", help=f"folder of the results; default: {default}"
    )
    command.add_argument("--quiet", action="store_true", help="print only errors")


def add_jobs(command: argparse.ArgumentParser) -> None:
    """Adds the number of processes."""
    command.add_argument(
        "--jobs",
        type=whole_number(1, 1000),
        default=os.cpu_count() or 1,
        metavar="N",
        help="number of concurrent processes; default: the number of cores",
    )


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """Returns the parser of an argument that is a whole number in [low, high]."""

    def parse(text: str) -> int:
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(
                f"expected a whole number in [{low}, {high}], got {text!r}"
            )
        return int(text)

    return parse


def number_in(low: float, high: float) -> Callable[[str], float]:
    """Returns the parser of an argument that is a number in [low, high]."""

    def parse(text: str) -> float:
        try:
            number = float(text)
        except ValueError:
            number = math.nan
        if not low <= number <= high:
            raise argparse.ArgumentTypeError(
                f"expected a number in [{low:g}, {high:g}], got {text!r}"
            )
        return number

    return parse


def load(arguments: argparse.Namespace) -> Scenario:
    """Returns the scenario with the keys that --set, --seed and --duration override."""
    pairs = [("--set", assignment) for assignment in arguments.set]
    for name in ("seed", "duration"):
        value = getattr(arguments, name, None)
        if value is not None:
            pairs.append((f"--{name}", f"{name}={value}"))
    return load_with_options(arguments.scenario, pairs)


def progress_bar(
    arguments: argparse.Namespace, name: str | None, total: float | None, unit: str, **others: Any
) -> tqdm:
    """Returns a bar up to `total`, if that is known; with --quiet it is not shown."""
    return tqdm(desc=name, total=total, unit=unit, disable=arguments.quiet, **others)


def flight_bar(
    arguments: argparse.Namespace, name: str, total_s: float, form: str = FLIGHT_BAR
) -> tqdm:
    """Returns a bar over simulated time."""
    return progress_bar(arguments, name, total_s, "s", bar_format=form)


def printer(arguments: argparse.Namespace) -> Callable[[str], None]:
    """Returns `print`, or with --quiet a function without effect."""
    return (lambda line: None) if arguments.quiet else print


def print_notes(say: Callable[[str], None], scenario: Scenario, others: Sequence[str] = ()) -> None:
    """Prints the notes on a scenario before its flight, and `others`."""
    from aerodrake.model.low_level.thrust_allocation import thrust_notes
    from aerodrake.model.residual.scenario_network import provenance_notes

    joints = len(scenario.vehicle.working_rad)
    notes = [*warnings(scenario), *provenance_notes(scenario, joints), *thrust_notes(scenario)]
    for note in (*notes, *others):
        say(f"note: {note}")
    print_compile_note(say)


def print_compile_note(say: Callable[[str], None]) -> None:
    """Prints a note if the equations are not compiled yet."""
    from aerodrake.support.compiled import is_cold

    if is_cold():
        say("note: compiling the equations first; this takes a minute, once per machine")


def new_folder(name: str) -> Path:
    """Returns runs/NAME-TIME, or the first of runs/NAME-TIME-2, -3, ... that does not exist."""
    first = Path("runs", f"{name}-{time.strftime('%Y%m%d-%H%M%S')}")
    others = (first.with_name(f"{first.name}-{i}") for i in itertools.count(2))
    return next(path for path in itertools.chain([first], others) if not path.exists())
