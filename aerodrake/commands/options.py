"""What several commands have in common: options, folders and progress bars."""

from __future__ import annotations

import argparse
import itertools
import math
import os
import time
from collections.abc import Callable
from pathlib import Path

FLIGHT_BAR = (
    "{desc} {percentage:3.0f}%|{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}, {rate_fmt}]"
)
"""Format of a progress bar over simulated time."""

LIVE_BAR = "{desc} {n:.1f}/{total:.1f} s{postfix} |{bar}|"
"""Of one that tells how the flight goes; it fits into 80 columns."""


LCM_URL = "udpm://239.255.76.67:7667?ttl=0"
"""LCM's own address, on this machine alone; ttl=1 reaches the others on its network."""


def add_scenario(command: argparse.ArgumentParser, default: str = "") -> None:
    """The scenario, and what overrides its keys."""
    place = "a packaged name, or the path of a YAML file"
    if default:
        place += f"; default: {default}"
        command.add_argument("scenario", nargs="?", default=default, help=place)
    else:
        command.add_argument("scenario", help=place)
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="overrides a dotted key"
    )


def add_output(command: argparse.ArgumentParser, default: str) -> None:
    """Where results go, and whether it is said."""
    command.add_argument("--out", type=Path, metavar="DIR", help=f"default: {default}")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")


def add_jobs(command: argparse.ArgumentParser) -> None:
    """How many processes at a time."""
    command.add_argument(
        "--jobs",
        type=whole_number(1, 1000),
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes at a time; default: the cores",
    )


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """A type of argument: a whole number in [low, high]."""

    def parse(text: str) -> int:
        if not text.isdecimal() or not low <= int(text) <= high:
            raise argparse.ArgumentTypeError(
                f"expected a whole number in [{low}, {high}], got {text!r}"
            )
        return int(text)

    return parse


def number_in(low: float, high: float) -> Callable[[str], float]:
    """A type of argument: a number in [low, high]."""

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


def overrides(arguments: argparse.Namespace) -> list[tuple[str, str]]:
    """The options that change the scenario, as typed, with their assignments."""
    found = [("--set", assignment) for assignment in arguments.set]
    for name in ("seed", "duration"):
        value = getattr(arguments, name, None)
        if value is not None:
            found.append((f"--{name}", f"{name}={value}"))
    return found


def new_folder(name: str) -> Path:
    """runs/NAME-TIME, or the first of runs/NAME-TIME-2, -3, ... that is not there yet."""
    first = Path("runs", f"{name}-{time.strftime('%Y%m%d-%H%M%S')}")
    others = (first.with_name(f"{first.name}-{i}") for i in itertools.count(2))
    return next(path for path in itertools.chain([first], others) if not path.exists())
