"""Command `aerodrake compare SCENARIO`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from aerodrake.commands import options
from aerodrake.scenario import Scenario, Weights
from aerodrake.scenario.inputs import frozen
from aerodrake.scenario.plain_yaml import dump
from aerodrake.scenario.schema import as_mapping
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.run_folder import run_folder

if TYPE_CHECKING:
    from aerodrake.comparison.page import Comparison

HELP = "compare variants of a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    command.add_argument(
        "--variant",
        action="append",
        default=[],
        metavar="NAME",
        help="fly this variant; may be given several times; default: all variants",
    )
    command.add_argument(
        "--margins",
        action="store_true",
        help="find the delay, rotor thrust and payload at which the error of each variant doubles, "
        "and at which the flight is not completed",
    )
    command.add_argument(
        "--baseline",
        type=Path,
        metavar="FILE",
        help="YAML file with the weights of integral_best; default: the packaged file of the "
        "scenario's name, or the default weights",
    )
    options.add_jobs(command)
    options.add_output(command, "runs/SCENARIO-comparison-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies all variants of a scenario and compares them with the paper's results."""
    original = options.load(arguments)
    target = arguments.out or options.new_folder(f"{original.name}-comparison")

    from aerodrake.comparison.compare import (
        FILES,
        RESULTS,
        load_baseline,
        make_variants,
        notes,
        result_notes,
    )
    from aerodrake.comparison.folder import draw_comparison
    from aerodrake.comparison.margins_report import FILES as MARGINS_FILES
    from aerodrake.comparison.margins_report import margins_table
    from aerodrake.comparison.table import comparison_table

    say = options.printer(arguments)
    with frozen(original) as scenario:
        baseline = load_baseline(scenario, arguments.baseline)
        variants = make_variants(scenario, arguments.variant, baseline)
        options.print_notes(say, scenario, notes(scenario))
        with run_folder(target, RESULTS) as folder:
            comparison = _fly(arguments, scenario, variants, baseline, folder)
        with deferred_interrupts():
            commands = _commands(arguments, target, comparison.logs)
            draw_comparison(target, comparison, dump(as_mapping(original)), commands)
    summaries, logs, margins = comparison.summaries, comparison.logs, comparison.margins
    say(comparison_table(summaries, scenario.reference.kind))
    for note in result_notes(summaries):
        say(f"note: {note}")
    if margins:
        say(f"\n{margins_table(margins)}")
    files = FILES + MARGINS_FILES if margins else FILES
    say(f"\n{target}: {', '.join(files)}, and the folder of a run for each variant")
    failed = len(logs) < len(variants) or (margins is not None and margins.failed)
    return 1 if failed else 0


def _fly(
    arguments: argparse.Namespace,
    scenario: Scenario,
    variants: dict[str, Scenario],
    baseline: Weights,
    folder: Path,
) -> Comparison:
    """Flies the variants, and with --margins searches their margins; writes the results."""
    from aerodrake.comparison.compare import compare, own_variant
    from aerodrake.comparison.margins import find_margins
    from aerodrake.comparison.margins_report import write_margins
    from aerodrake.comparison.page import Comparison
    from aerodrake.flight.log import FlightLog
    from aerodrake.flight.summary import headline, to_json
    from aerodrake.model.vehicle.vehicle import VehicleModel

    name, jobs = scenario.name, arguments.jobs
    with options.progress_bar(arguments, name, len(variants), "variant") as bar:
        summaries = compare(variants, folder, jobs, lambda name: bar.update())
    with deferred_interrupts():
        figures = {"scenario": name, "variants": summaries}
        (folder / "comparison.json").write_text(to_json(figures), encoding="utf-8")
        vehicle = VehicleModel.load(scenario)  # The same in all variants.
        logs = {
            name: FlightLog.read(folder / name / "log.npz", summary, vehicle)
            for name, summary in summaries.items()
            if summary["exit_reason"] != "failed"
        }
    margins = None
    if arguments.margins:
        with options.progress_bar(arguments, f"{name} margins", None, "flight") as bar:
            margins = find_margins(variants, summaries, headline(summaries), jobs, bar.update)
        with deferred_interrupts():
            write_margins(margins, scenario, folder)
    own = own_variant(scenario)
    return Comparison(scenario, variants, own, summaries, logs, margins)


def _commands(arguments: argparse.Namespace, target: Path, names: Iterable[str]) -> list[str]:
    """Returns the command that repeats the comparison, and the command of each variant's flight."""
    words = [f"--set={assignment}" for assignment in arguments.set]
    words += [f"--variant={name}" for name in arguments.variant]
    if arguments.baseline:
        words += [f"--baseline={arguments.baseline}"]
    words += ["--margins"] * arguments.margins
    again = ["aerodrake", "compare", arguments.scenario, *words]
    flights = [["aerodrake", "run", str(target / name / "scenario.yaml")] for name in names]
    return [shlex.join(command) for command in (again, *flights)]
