"""Command `aerodrake run SCENARIO`."""

import argparse
import sys

from aerodrake.commands import options
from aerodrake.support.errors import BadInput
from aerodrake.support.interrupts import lasting_deferral
from aerodrake.support.limits import RATE
from aerodrake.support.run_folder import check_target

HELP = "fly a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    options.add_short_forms(command)
    command.add_argument(
        "--live", action="store_true", help="show the flight in a browser in real time"
    )
    command.add_argument(
        "--rate",
        type=options.number_in(*RATE),
        metavar="R",
        help="with --live: ratio of simulated time to wall time; default: 1",
    )
    command.add_argument(
        "--lcm",
        nargs="?",
        const=options.LCM_URL,
        metavar="URL",
        help="fly in real time with `aerodrake coordinator` in another process, over LCM at URL; "
        f"default: {options.LCM_URL}",
    )
    options.add_output(command, "runs/SCENARIO-TIME; replaces earlier results in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario, writes its results and prints a table."""
    if arguments.rate is not None and not arguments.live:
        raise BadInput("rate", "", "expected --live; other flights do not run at a given rate")
    if arguments.rate is not None and arguments.lcm:
        raise BadInput("rate", "", "expected no --lcm, which flies in real time")
    scenario = options.load(arguments)
    target = arguments.out or options.new_folder(scenario.name)
    check_target(target)

    from aerodrake.api.console import Console
    from aerodrake.api.fly import fly
    from aerodrake.reports.flight_folder import DRAWINGS, RESULTS
    from aerodrake.reports.live import LiveView

    view = None
    if arguments.live:
        view = LiveView(arguments.rate or 1.0, lambda line: print(line, file=sys.stderr))
    with lasting_deferral():
        result = fly(scenario, view=view, lcm=arguments.lcm, quiet=arguments.quiet)
        result.save(target)
        result.report(target)
    Console(arguments.quiet).say(f"{result}\n\n{target}: {', '.join((*RESULTS, *DRAWINGS))}")
    return 0 if result.exit_reason == "completed" else 1
