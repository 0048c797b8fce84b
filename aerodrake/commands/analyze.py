"""Command `aerodrake analyze SCENARIO`."""

import argparse

from aerodrake.commands import options
from aerodrake.support.errors import BadInput
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.limits import REFERENCE_TIME
from aerodrake.support.run_folder import check_target

HELP = "find the modes and stability margins of a scenario's closed loop"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    command.add_argument(
        "--at",
        action="extend",
        nargs="+",
        default=[],
        type=options.number_in(*REFERENCE_TIME),
        metavar="TIME",
        help="linearise about the flight at these reference times in s as well",
    )
    options.add_output(command, "runs/SCENARIO-analysis-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Linearises the closed loop of a scenario, writes its modes and margins and prints a table.

    The exit code is 1 if the loop is unstable.
    """
    scenario = options.load(arguments)
    target = arguments.out or options.new_folder(f"{scenario.name}-analysis")

    from aerodrake.analysis.folder import DRAWINGS, RESULTS
    from aerodrake.api.analyze import analyze
    from aerodrake.api.console import Console

    check_target(target, RESULTS)
    try:
        result = analyze(scenario, times=arguments.at, quiet=arguments.quiet)
    except BadInput as error:
        if error.key != "times":
            raise
        raise BadInput("at", "", error.args[-1]) from None
    with deferred_interrupts():
        result.save(target)
        result.report(target)
    Console(arguments.quiet).say(f"{result}\n\n{target}: {', '.join((*RESULTS, *DRAWINGS))}")
    return 0 if result.is_stable else 1
