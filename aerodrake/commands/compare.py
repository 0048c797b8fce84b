"""`aerodrake compare SCENARIO`."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Iterable
from pathlib import Path

from aerodrake.commands.options import add_jobs, add_output, add_scenario, new_folder, overrides

HELP = "fly all variants"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    add_scenario(command)
    command.add_argument(
        "--variant",
        action="append",
        default=[],
        metavar="NAME",
        help="flies this one; may be given again; default: all",
    )
    command.add_argument(
        "--margins",
        action="store_true",
        help="find the delay, loop gain and payload at which each doubles its error and is lost",
    )
    command.add_argument(
        "--baseline",
        type=Path,
        metavar="FILE",
        help="YAML with the weights of integral_best; default: packaged for SCENARIO's name, or "
        "the default weights",
    )
    add_jobs(command)
    add_output(
        command, "runs/SCENARIO-comparison-TIME; an earlier one there is replaced as a whole"
    )


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario in every variant, beside the paper's figures."""
    from tqdm import tqdm

    from aerodrake.scenario.load import load_scenario

    given = load_scenario(arguments.scenario, overrides(arguments))
    target = arguments.out or new_folder(f"{given.name}-comparison")

    from aerodrake.comparison.baseline import load_baseline
    from aerodrake.comparison.compare import (
        FILES,
        OWN_VARIANT,
        compare,
        make_variant,
        make_variants,
        notes,
    )
    from aerodrake.comparison.figure import plot_comparison
    from aerodrake.comparison.margins import find_margins
    from aerodrake.comparison.margins_report import FILES as MARGINS_FILES
    from aerodrake.comparison.margins_report import margins_table, write_margins
    from aerodrake.comparison.page import Comparison, comparison_page
    from aerodrake.comparison.table import comparison_table
    from aerodrake.flight.log import FlightLog
    from aerodrake.flight.summary import headline, to_json
    from aerodrake.model.low_level.thrust_allocation import thrust_notes
    from aerodrake.model.residual.scenario_network import provenance_notes
    from aerodrake.scenario.inputs import frozen
    from aerodrake.scenario.plain_yaml import dump
    from aerodrake.scenario.rules import warnings
    from aerodrake.scenario.schema import as_mapping
    from aerodrake.support.compiled import is_cold
    from aerodrake.support.interrupts import held_interrupts
    from aerodrake.support.run_folder import run_folder

    say = (lambda line: None) if arguments.quiet else print
    jobs, margins, written = arguments.jobs, None, FILES
    with frozen(given) as scenario:
        baseline = load_baseline(scenario, arguments.baseline)
        variants = make_variants(scenario, arguments.variant, baseline)
        joints = len(scenario.vehicle.working_rad)
        known = (*provenance_notes(scenario, joints), *thrust_notes(scenario), *notes(scenario))
        for note in (*warnings(scenario), *known):
            say(f"note: {note}")
        if is_cold():
            say("note: equations are compiled first; this takes a minute, once on a machine")
        with run_folder(target, FILES) as folder:
            with tqdm(
                total=len(variants), desc=scenario.name, unit="variant", disable=arguments.quiet
            ) as bar:
                summaries = compare(variants, folder, jobs, lambda name: bar.update())
            with held_interrupts():
                figures = {"scenario": scenario.name, "variants": summaries}
                (folder / "comparison.json").write_text(to_json(figures), encoding="utf-8")
                logs = {
                    name: FlightLog.read(folder / name / "log.npz", summary)
                    for name, summary in summaries.items()
                    if summary["exit_reason"] != "failed"
                }
                own = OWN_VARIANT[scenario.residual.mode]
                title = f"{scenario.name}, seed {scenario.seed}"
                plot_comparison(
                    logs,
                    own,
                    make_variant(scenario, own, baseline),
                    title,
                    folder / "comparison.png",
                )
            if arguments.margins:
                title = f"{scenario.name} margins"
                with tqdm(desc=title, unit="flight", disable=arguments.quiet) as bar:
                    margins = find_margins(
                        variants, summaries, headline(summaries), jobs, bar.update
                    )
                with held_interrupts():
                    write_margins(margins, scenario, folder)
                written += MARGINS_FILES
            with held_interrupts():
                comparison = Comparison(scenario, variants, own, summaries, logs, margins)
                page = comparison_page(
                    comparison, dump(as_mapping(given)), _commands(arguments, target, logs)
                )
                (folder / "report.html").write_text(page, encoding="utf-8")
    say(comparison_table(summaries, scenario.reference.kind))
    if margins:
        say(f"\n{margins_table(margins)}")
    say(f"\n{target}: {', '.join(written)}, and a run's folder for each variant")
    failed = len(logs) < len(variants) or (margins is not None and margins.failed)
    return 1 if failed else 0


def _commands(arguments: argparse.Namespace, target: Path, names: Iterable[str]) -> list[str]:
    """What compares the same again, and what flies each variant."""
    options = [f"--set={assignment}" for assignment in arguments.set]
    options += [f"--variant={name}" for name in arguments.variant]
    if arguments.baseline:
        options += [f"--baseline={arguments.baseline}"]
    options += ["--margins"] * arguments.margins
    again = ["aerodrake", "compare", arguments.scenario, *options]
    flights = [["aerodrake", "run", str(target / name / "scenario.yaml")] for name in names]
    return [shlex.join(command) for command in (again, *flights)]
