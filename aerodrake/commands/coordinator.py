"""Command `aerodrake coordinator SCENARIO`."""

import argparse

from aerodrake.commands.options import (
    FLIGHT_BAR,
    LCM_URL,
    add_scenario,
    overrides,
    print_compile_note,
    printer,
)

HELP = "run the coordinator for a station in another process, over LCM"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    add_scenario(command)
    command.add_argument("--lcm", default=LCM_URL, metavar="URL", help=f"default: {LCM_URL}")
    command.add_argument("--quiet", action="store_true", help="print only errors")


def main(arguments: argparse.Namespace) -> int:
    """Runs the coordinator in wall time for one flight of `aerodrake run SCENARIO --lcm`."""
    from tqdm import tqdm

    from aerodrake.scenario.load import load_scenario

    scenario = load_scenario(arguments.scenario, overrides(arguments))

    from aerodrake.scenario.inputs import frozen
    from aerodrake.support.errors import ProcessDied
    from aerodrake.support.garbage import frozen_garbage
    from aerodrake.support.interrupts import deferred_interrupts
    from aerodrake.wire.companion import Companion
    from aerodrake.wire.link import make_lcm

    say = printer(arguments)
    lcm = make_lcm(arguments.lcm)
    print_compile_note(say)
    with frozen(scenario) as scenario:  # Reads the files as the station does.
        companion = Companion(scenario, lcm, say)
    say(f"note: waiting for a station at {arguments.lcm}")
    try:
        with (
            deferred_interrupts() as check,
            frozen_garbage(),
            tqdm(
                total=scenario.settle_s + scenario.duration,
                desc=scenario.name,
                unit="s",
                disable=arguments.quiet,
                bar_format=FLIGHT_BAR,
            ) as bar,
        ):

            def progress(flown_s: float) -> None:
                bar.total = max(bar.total, flown_s)  # The station determines the duration.
                bar.update(flown_s - bar.n)
                check()

            companion.serve(progress)
    finally:
        say(companion.service.line())
    if companion.service.fault:
        raise ProcessDied(companion.service.fault)
    return 0
