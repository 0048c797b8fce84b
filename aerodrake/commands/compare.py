"""Command `aerodrake compare SCENARIO`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from aerodrake.commands.options import (
    add_jobs,
    add_output,
    add_scenario,
    new_folder,
    overrides,
    print_notes,
    printer,
)

if TYPE_CHECKING:
    from aerodrake.comparison.margins import Margins
    from aerodrake.comparison.page import Comparison
    from aerodrake.flight.summary import Summaries
    from aerodrake.scenario import Scenario, Weights

HELP = "compare variants of a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    add_scenario(command)
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
        help="find the delay, loop gain and payload at which the error of each variant doubles, "
        "and at which it is lost",
    )
    command.add_argument(
        "--baseline",
        type=Path,
        metavar="FILE",
        help="YAML file with the weights of integral_best; default: the packaged file of the "
        "scenario's name, or the default weights",
    )
    add_jobs(command)
    add_output(command, "runs/SCENARIO-comparison-TIME; replaces an earlier comparison in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies all variants of a scenario and compares them with the paper's figures."""
    from aerodrake.scenario.load import load_scenario

    original = load_scenario(arguments.scenario, overrides(arguments))
    target = arguments.out or new_folder(f"{original.name}-comparison")

    from aerodrake.comparison.compare import FILES, load_baseline, make_variants, notes
    from aerodrake.comparison.margins_report import FILES as MARGINS_FILES
    from aerodrake.comparison.margins_report import margins_table
    from aerodrake.comparison.page import comparison_page
    from aerodrake.comparison.table import comparison_table
    from aerodrake.scenario.inputs import frozen
    from aerodrake.scenario.plain_yaml import dump
    from aerodrake.scenario.schema import as_mapping
    from aerodrake.support.interrupts import deferred_interrupts
    from aerodrake.support.run_folder import run_folder

    say = printer(arguments)
    with frozen(original) as scenario:
        baseline = load_baseline(scenario, arguments.baseline)
        variants = make_variants(scenario, arguments.variant, baseline)
        print_notes(say, scenario, notes(scenario))
        with run_folder(target, FILES) as folder:
            comparison = _fly(arguments, scenario, variants, baseline, folder)
            with deferred_interrupts():
                commands = _commands(arguments, target, comparison.logs)
                page = comparison_page(comparison, dump(as_mapping(original)), commands)
                (folder / "report.html").write_text(page, encoding="utf-8")
    summaries, logs, margins = comparison.summaries, comparison.logs, comparison.margins
    say(comparison_table(summaries, scenario.reference.kind))
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
    """Flies the variants, with --margins also to their margins, and writes figures and results."""
    from tqdm import tqdm

    from aerodrake.comparison.compare import OWN_VARIANT, compare, make_variant
    from aerodrake.comparison.figure import plot_comparison
    from aerodrake.comparison.page import Comparison
    from aerodrake.flight.log import FlightLog
    from aerodrake.flight.summary import to_json
    from aerodrake.model.vehicle.vehicle import VehicleModel
    from aerodrake.support.interrupts import deferred_interrupts

    with tqdm(
        total=len(variants), desc=scenario.name, unit="variant", disable=arguments.quiet
    ) as bar:
        summaries = compare(variants, folder, arguments.jobs, lambda name: bar.update())
    with deferred_interrupts():
        figures = {"scenario": scenario.name, "variants": summaries}
        (folder / "comparison.json").write_text(to_json(figures), encoding="utf-8")
        vehicle = VehicleModel.load(scenario)  # The same in all variants.
        logs = {
            name: FlightLog.read(folder / name / "log.npz", summary, vehicle)
            for name, summary in summaries.items()
            if summary["exit_reason"] != "failed"
        }
        own = OWN_VARIANT[scenario.residual.mode]
        own_scenario = make_variant(scenario, own, baseline)
        title = f"{scenario.name}, seed {scenario.seed}"
        plot_comparison(logs, own, own_scenario, title, folder / "comparison.png")
    margins = _find_margins(arguments, scenario, variants, summaries, folder)
    return Comparison(scenario, variants, own, summaries, logs, margins)


def _find_margins(
    arguments: argparse.Namespace,
    scenario: Scenario,
    variants: dict[str, Scenario],
    summaries: Summaries,
    folder: Path,
) -> Margins | None:
    """Finds and writes the variants' margins; returns None without --margins."""
    from tqdm import tqdm

    from aerodrake.comparison.margins import find_margins
    from aerodrake.comparison.margins_report import write_margins
    from aerodrake.flight.summary import headline
    from aerodrake.support.interrupts import deferred_interrupts

    if not arguments.margins:
        return None
    with tqdm(desc=f"{scenario.name} margins", unit="flight", disable=arguments.quiet) as bar:
        margins = find_margins(variants, summaries, headline(summaries), arguments.jobs, bar.update)
    with deferred_interrupts():
        write_margins(margins, scenario, folder)
    return margins


def _commands(arguments: argparse.Namespace, target: Path, names: Iterable[str]) -> list[str]:
    """Returns the command that repeats the comparison, and the command of each variant's flight."""
    options = [f"--set={assignment}" for assignment in arguments.set]
    options += [f"--variant={name}" for name in arguments.variant]
    if arguments.baseline:
        options += [f"--baseline={arguments.baseline}"]
    options += ["--margins"] * arguments.margins
    again = ["aerodrake", "compare", arguments.scenario, *options]
    flights = [["aerodrake", "run", str(target / name / "scenario.yaml")] for name in names]
    return [shlex.join(command) for command in (again, *flights)]
