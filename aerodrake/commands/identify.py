"""Command `aerodrake identify [SCENARIO]`."""

import argparse
from pathlib import Path

from aerodrake.commands import options
from aerodrake.scenario.edit import check_replaceable, replace_numbers
from aerodrake.support.errors import BadInput
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.run_folder import check_target

HELP = "identify K_B of a scenario's equivalent model"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command, default="clover_paper")
    command.add_argument(
        "--write", action="store_true", help="write K_B to model.k_b of the scenario's file"
    )
    options.add_jobs(command)
    options.add_output(command, "runs/identify-SCENARIO-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Identifies K_B of a scenario's equivalent model, writes the results and prints a table."""
    scenario = options.load(arguments)
    file = Path(scenario.source)
    if arguments.write:
        if arguments.set:
            raise BadInput("write", "", "expected no --set, since K_B is written to the file")
        check_replaceable(file, "model.k_b")
    target = arguments.out or options.new_folder(f"identify-{scenario.name}")

    from aerodrake.api.console import Console
    from aerodrake.api.identify import identify
    from aerodrake.identification.report import FIGURE, RESULTS

    check_target(target, RESULTS)
    result = identify(scenario, jobs=arguments.jobs, quiet=arguments.quiet)
    with deferred_interrupts():
        result.save(target)
        result.report(target)
    say = Console(arguments.quiet).say
    say(f"{target}: {', '.join((*RESULTS, FIGURE))}")
    if arguments.write:
        replace_numbers(file, "model.k_b", result.k_b)
        say(f"{file}: model.k_b replaced")
    say(f"\n{result}\n\n--set 'model.k_b=[{','.join(f'{k:g}' for k in result.k_b)}]'")
    return 0
