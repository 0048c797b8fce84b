"""Command `aerodrake bench`."""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aerodrake.commands import options
from aerodrake.support.errors import BadInput
from aerodrake.support.files import write_atomically
from aerodrake.support.run_folder import run_folder

HELP = "measure computation times and memory, or fly real arms"

QUICK_FLOWN_S, FLOWN_S = 3.0, 60.0
"""Longest reference time of the flights of real arms."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    command.add_argument("--quick", action="store_true", help="shorter flights, fewer repetitions")
    command.add_argument(
        "--robots",
        action="store_true",
        help="instead mount the arms of the extra [robots] below multirotors, and fly them",
    )
    command.add_argument(
        "--json", type=Path, metavar="FILE", help="also write the figures to FILE; replaces it"
    )
    options.add_output(command, "runs/bench-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Measures the MPC's tick beside other solvers, the closed loop beside its plant, and memory.

    Skips solvers that are not installed; pip install aerodrake[bench] installs them. With
    --robots, the exit code is 1 if an arm's flight is not completed.
    """
    file = arguments.json
    if file is not None and (file.is_dir() or not file.parent.is_dir()):
        raise BadInput("json", "", f"expected a file in an existing folder, got {file}")
    target = arguments.out or options.new_folder("bench")
    return (_fly_robots if arguments.robots else _measure)(arguments, target)


def _measure(arguments: argparse.Namespace, target: Path) -> int:
    from aerodrake.api.console import Console
    from aerodrake.bench.figure import plot_bench
    from aerodrake.bench.report import FILES, bench_table, missing_peers
    from aerodrake.bench.suite import FULL, QUICK, STEPS, bench
    from aerodrake.reports.drawing import drawing

    console = Console(arguments.quiet)
    console.note(missing_peers())
    with run_folder(target, FILES[:1]) as folder:
        with console.steps(STEPS, "step") as begin:
            figures = bench(QUICK if arguments.quick else FULL, begin)
        _write(figures, folder / FILES[0], arguments.json)
    path = target / FILES[1]
    with drawing(path):
        plot_bench(figures, path)
    console.say(bench_table(figures))
    console.say(f"\n{target}: {', '.join(FILES)}")
    return 0


def _fly_robots(arguments: argparse.Namespace, target: Path) -> int:
    from aerodrake.api.console import Console
    from aerodrake.bench.robots import ARMS, robots_figures
    from aerodrake.bench.robots_report import FILE, robots_table

    console = Console(arguments.quiet)
    flown_s = QUICK_FLOWN_S if arguments.quick else FLOWN_S
    with run_folder(target, (FILE,)) as folder:
        with console.steps(len(ARMS), "arm") as begin:
            figures = robots_figures(ARMS, folder, flown_s, begin)
        _write(figures, folder / FILE, arguments.json)
    console.say(robots_table(figures))
    console.say(f"\n{target}: {FILE} and a folder for each vehicle")
    return 0 if all(arm["exit_reason"] == "completed" for arm in figures["arms"]) else 1


def _write(figures: Mapping[str, Any], path: Path, copy: Path | None) -> None:
    """Writes the figures as JSON, and a copy if a path is given."""
    from aerodrake.flight.summary import to_json

    path.write_text(to_json(figures), encoding="utf-8")
    if copy is not None:
        write_atomically(copy, to_json(figures).encode())
