"""The command line: `aerodrake run | compare | identify | graph`."""

from __future__ import annotations

import argparse
import itertools
import os
import shlex
import sys
import time
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from aerodrake.errors import BadInput

# Drake and torch take seconds to import: each command imports what it needs.

BAR = "{desc} {percentage:3.0f}%|{bar}| {n:.1f}/{total:.1f} s [{elapsed}<{remaining}, {rate_fmt}]"


def main(argv: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        0 on success, 1 on a flight that did not complete, 2 on bad input,
        130 if interrupted outside of the flight.
    """
    arguments = _parser().parse_args(argv)
    try:
        return arguments.command(arguments)
    except BadInput as error:
        print(f"aerodrake: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("aerodrake: interrupted", file=sys.stderr)
        return 130


def run(arguments: argparse.Namespace) -> int:
    """Flies a scenario; writes its results and prints the table."""
    from tqdm import tqdm

    from aerodrake.scenario_file import load_scenario
    from aerodrake.scenario_rules import warnings

    scenario = load_scenario(arguments.scenario, _overrides(arguments))
    target = arguments.out or _new_folder(scenario.name)

    from aerodrake.flight_folder import fly_into
    from aerodrake.replay import write_replay
    from aerodrake.report import table
    from aerodrake.run_folder import run_folder
    from aerodrake.simulate import Flight

    say = (lambda line: None) if arguments.quiet else print
    for warning in warnings(scenario):
        say(f"note: {warning}")
    flight = Flight(scenario)
    with run_folder(target) as folder:
        with tqdm(
            total=scenario.settle_s + scenario.duration,
            desc=scenario.name,
            unit="s",
            disable=arguments.quiet,
            bar_format=BAR,
        ) as bar:
            title = f"{scenario.name}, seed {scenario.seed}"
            summary, log = fly_into(folder, flight, title, lambda t: bar.update(t - bar.n))
        write_replay(log, scenario, folder / "replay.html")
    say(table(summary, scenario.reference.kind))
    say(f"\n{target}: summary.json, log.npz, scenario.yaml, tracking.png, replay.html")
    return 0 if log.exit_reason == "completed" else 1


def compare(arguments: argparse.Namespace) -> int:
    """Flies a scenario in every variant, beside the paper's figures."""
    from tqdm import tqdm

    from aerodrake.scenario_file import load_scenario

    scenario = load_scenario(arguments.scenario, _overrides(arguments))
    target = arguments.out or _new_folder(f"{scenario.name}-comparison")

    from aerodrake.compare import OWN_VARIANT, compare, make_variants, notes
    from aerodrake.comparison_report import comparison_table, plot_comparison
    from aerodrake.flight_log import FlightLog
    from aerodrake.run_folder import COMPARISON_MARKERS, run_folder
    from aerodrake.summary import to_json

    say = (lambda line: None) if arguments.quiet else print
    variants = make_variants(scenario)
    for note in notes(scenario):
        say(f"note: {note}")
    with run_folder(target, COMPARISON_MARKERS) as folder:
        with tqdm(
            total=len(variants), desc=scenario.name, unit="variant", disable=arguments.quiet
        ) as bar:
            summaries = compare(variants, folder, arguments.jobs, lambda name: bar.update())
        comparison = {"scenario": scenario.name, "variants": summaries}
        (folder / "comparison.json").write_text(to_json(comparison), encoding="utf-8")
        logs = {
            name: FlightLog.read(folder / name / "log.npz", summary)
            for name, summary in summaries.items()
            if summary["exit_reason"] != "failed"
        }
        own = OWN_VARIANT[scenario.residual.mode]
        title = f"{scenario.name}, seed {scenario.seed}"
        plot_comparison(logs, own, variants[own], title, folder / "comparison.png")
    say(comparison_table(summaries, scenario.reference.kind))
    say(f"\n{target}: comparison.json, comparison.png, and a run's folder for each variant")
    return 0 if len(logs) == len(variants) else 1


def identify(arguments: argparse.Namespace) -> int:
    """Identifies K_B of a scenario's equivalent model; writes and prints it."""
    from tqdm import tqdm

    from aerodrake.scenario_edit import check_replaceable, replace_numbers
    from aerodrake.scenario_file import load_scenario

    scenario = load_scenario(arguments.scenario, _overrides(arguments))
    if arguments.write:
        if arguments.set:
            raise BadInput("--write", "", "expected no --set, for K_B is that of the file as it is")
        check_replaceable(Path(scenario.source), "model.k_b")
    target = arguments.out or _new_folder(f"identify-{scenario.name}")

    from aerodrake import identify_report
    from aerodrake.identify import DURATION_S, FLIGHTS, identify
    from aerodrake.run_folder import run_folder

    say = (lambda line: None) if arguments.quiet else print
    options = [f"--set={assignment}" for assignment in arguments.set]
    command = shlex.join(["aerodrake", "identify", arguments.scenario, *options])
    with run_folder(target, identify_report.FILES) as folder:
        with tqdm(
            total=FLIGHTS * DURATION_S,
            desc=f"identify {scenario.name}",
            unit="s",
            disable=arguments.quiet,
            bar_format=BAR,
        ) as bar:
            found = identify(scenario, arguments.jobs, progress=bar.update)
        identify_report.write(found, command, folder)
    say(f"{target}: {', '.join(identify_report.FILES)}")
    if arguments.write:
        replace_numbers(Path(scenario.source), "model.k_b", found.k_b)
        say(f"{scenario.source}: model.k_b replaced")
    say(f"\n{identify_report.table(found)}")
    return 0


def graph(arguments: argparse.Namespace) -> int:
    """Writes the graphs of the closed loop, its two sides, or single systems."""
    from aerodrake.graph import export_all
    from aerodrake.scenario_file import load_scenario
    from aerodrake.station import make_closed_loop

    names = [arguments.name] if arguments.name else []
    closed_loop = make_closed_loop(load_scenario("hover"))
    for path in export_all(closed_loop, names, arguments.out, arguments.depth):
        print(path)
    return 0


class _Parser(argparse.ArgumentParser):
    """Says what is wrong in one line, as every other bad input does."""

    def error(self, message: str) -> None:
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(
        prog="aerodrake",
        description="Predictive kinematic control of aerial manipulators as a Drake diagram.",
    )
    parser.add_argument("--version", action="version", version=f"aerodrake {version('aerodrake')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    command = commands.add_parser("run", help="fly a scenario", description=run.__doc__)
    command.add_argument("scenario", help="a packaged name, or the path of a YAML file")
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="default: runs/SCENARIO-TIME; an earlier run there is replaced as a whole",
    )
    command.add_argument("--seed", metavar="N", help="overrides the scenario's seed")
    command.add_argument("--duration", metavar="S", help="reference time to fly, in s")
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="overrides a dotted key"
    )
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(command=run)

    command = commands.add_parser("compare", help="fly all variants", description=compare.__doc__)
    command.add_argument("scenario", help="a packaged name, or the path of a YAML file")
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="default: runs/SCENARIO-comparison-TIME; an earlier one there is replaced as a whole",
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="overrides a dotted key"
    )
    command.add_argument(
        "--jobs", type=_jobs, default=os.cpu_count() or 1, metavar="N", help="default: the cores"
    )
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(command=compare)

    command = commands.add_parser(
        "identify", help="identify K_B of a scenario's model", description=identify.__doc__
    )
    command.add_argument(
        "scenario",
        nargs="?",
        default="clover_paper",
        help="a packaged name, or the path of a YAML file; default: clover_paper",
    )
    command.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help="default: runs/identify-SCENARIO-TIME; an earlier one there is replaced as a whole",
    )
    command.add_argument(
        "--set", action="append", default=[], metavar="KEY=VALUE", help="overrides a dotted key"
    )
    command.add_argument(
        "--write", action="store_true", help="put K_B into the scenario's file, at model.k_b"
    )
    command.add_argument(
        "--jobs", type=_jobs, default=os.cpu_count() or 1, metavar="N", help="default: the cores"
    )
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")
    command.set_defaults(command=identify)

    command = commands.add_parser("graph", help="draw diagrams", description=graph.__doc__)
    command.add_argument(
        "name", nargs="?", help="closed_loop, station, coordinator or a system; default: all"
    )
    command.add_argument("--out", type=Path, default=Path("graphs"), metavar="DIR")
    command.add_argument("--depth", type=_depth, default=2, metavar="N", help="levels of nesting")
    command.set_defaults(command=graph)
    return parser


def _new_folder(name: str) -> Path:
    """runs/NAME-TIME, or the first of runs/NAME-TIME-2, -3, ... that is not there yet."""
    first = Path("runs", f"{name}-{time.strftime('%Y%m%d-%H%M%S')}")
    others = (first.with_name(f"{first.name}-{i}") for i in itertools.count(2))
    return next(path for path in itertools.chain([first], others) if not path.exists())


def _depth(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"expected a whole number from 0, got {text!r}")
    return int(text)


def _jobs(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1000:
        raise argparse.ArgumentTypeError(f"expected a whole number in [1, 1000], got {text!r}")
    return int(text)


def _overrides(arguments: argparse.Namespace) -> list[tuple[str, str]]:
    """The options that change the scenario, as typed, with their assignments."""
    overrides = [("--set", assignment) for assignment in arguments.set]
    for name in ("seed", "duration"):
        value = getattr(arguments, name, None)
        if value is not None:
            overrides.append((f"--{name}", f"{name}={value}"))
    return overrides
