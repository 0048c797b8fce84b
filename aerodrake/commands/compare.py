"""Command `aerodrake compare SCENARIO`."""

import argparse
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.run_folder import check_target

HELP = "compare variants of a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    options.add_short_forms(command)
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
    command.add_argument(
        "--engines",
        action="store_true",
        help="instead fly the scenario in both physics engines, and show how the flights differ",
    )
    options.add_jobs(command)
    options.add_output(command, "runs/SCENARIO-comparison-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies all variants of a scenario and compares them with the paper's results."""
    scenario = options.load(arguments)
    target = arguments.out or options.new_folder(f"{scenario.name}-comparison")

    from aerodrake.api.compare import compare
    from aerodrake.api.comparison_result import RESULTS
    from aerodrake.api.console import Console

    check_target(target, RESULTS)
    result = compare(
        scenario,
        variants=arguments.variant,
        baseline=arguments.baseline,
        margins=arguments.margins,
        engines=arguments.engines,
        jobs=arguments.jobs,
        quiet=arguments.quiet,
    )
    with deferred_interrupts():
        result.save(target)
        result.report(target)
    files = ", ".join(sorted(path.name for path in target.iterdir() if path.is_file()))
    text = f"{result}\n\n{target}: {files}, and the folder of a run for each variant"
    Console(arguments.quiet).say(text)
    return 1 if result.failed else 0
