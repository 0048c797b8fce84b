"""Command `aerodrake coordinator SCENARIO`."""

import argparse

from aerodrake.commands import options
from aerodrake.scenario.inputs import frozen
from aerodrake.support.errors import ProcessDied
from aerodrake.support.garbage import frozen_garbage
from aerodrake.support.interrupts import deferred_interrupts

HELP = "run the coordinator for a station in another process, over LCM"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    url = options.LCM_URL
    command.add_argument("--lcm", default=url, metavar="URL", help=f"default: {url}")
    command.add_argument("--quiet", action="store_true", help="print only errors")


def main(arguments: argparse.Namespace) -> int:
    """Runs the coordinator in wall time for one flight of `aerodrake run SCENARIO --lcm`."""
    scenario = options.load(arguments)

    from aerodrake.api.console import Console
    from aerodrake.wire.companion import Companion
    from aerodrake.wire.interface import make_lcm

    console = Console(arguments.quiet)
    lcm = make_lcm(arguments.lcm)
    console.note([])
    with frozen(scenario) as scenario:  # Reads the files as the station does.
        companion = Companion(scenario, lcm, console.say)
    console.say(f"note: waiting for a station at {arguments.lcm}")
    bar = console.flight_bar(scenario.name, scenario.settle_s + scenario.duration)
    try:
        with deferred_interrupts() as check, frozen_garbage(), bar:

            def progress(flown_s: float) -> None:
                bar.total = max(bar.total, flown_s)  # The station determines the duration.
                bar.update(flown_s - bar.n)
                check()

            companion.serve(progress)
    finally:
        console.say(companion.service.line())
    if companion.service.fault:
        raise ProcessDied(companion.service.fault)
    return 0
