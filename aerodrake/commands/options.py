"""Arguments and folders that several commands share."""

import argparse
import itertools
import time
from collections.abc import Callable
from pathlib import Path

from aerodrake.scenario import Scenario
from aerodrake.scenario.load import load_with_options
from aerodrake.support.decimals import read_decimal
from aerodrake.support.limits import JOBS

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


def add_short_forms(command: argparse.ArgumentParser) -> None:
    """Adds the options that override the seed and the duration."""
    command.add_argument("--seed", metavar="N", help="override the scenario's seed")
    command.add_argument(
        "--duration",
        metavar="S",
        help="override the duration, in s of reference time, which begins after the hover of "
        "settle_s at the start",
    )


def add_output(command: argparse.ArgumentParser, default: str) -> None:
    """Adds the folder of the results and the option not to print."""
    command.add_argument(
        "--out", type=Path, metavar="DIR", help=f"folder of the results; default: {default}"
    )
    command.add_argument("--quiet", action="store_true", help="print only errors")


def add_jobs(command: argparse._ActionsContainer) -> None:
    """Adds the number of processes."""
    command.add_argument(
        "--jobs",
        type=whole_number(*JOBS),
        metavar="N",
        help="number of concurrent processes; default: the number of cores",
    )


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """Returns the parser of an argument that is a whole number in [low, high]."""

    def parse(text: str) -> int:
        if not (text.isascii() and text.isdecimal()) or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(
                f"expected a whole number in [{low}, {high}], got {text!r}"
            )
        return int(text)

    return parse


def number_in(low: float, high: float) -> Callable[[str], float]:
    """Returns the parser of an argument that is a number in [low, high]."""

    def parse(text: str) -> float:
        number = read_decimal(text)
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


def new_folder(name: str) -> Path:
    """Returns runs/NAME-TIME, or the first of runs/NAME-TIME-2, -3, ... that does not exist."""
    first = Path("runs", f"{name}-{time.strftime('%Y%m%d-%H%M%S')}")
    others = (first.with_name(f"{first.name}-{i}") for i in itertools.count(2))
    return next(path for path in itertools.chain([first], others) if not path.exists())
