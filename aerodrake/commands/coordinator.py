"""`aerodrake coordinator SCENARIO`."""

from __future__ import annotations

import argparse

from aerodrake.commands.options import FLIGHT_BAR, LCM_URL, add_scenario, overrides

HELP = "coordinate the flight of a station in another process, over LCM"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    add_scenario(command)
    command.add_argument("--lcm", default=LCM_URL, metavar="URL", help=f"default: {LCM_URL}")
    command.add_argument("--quiet", action="store_true", help="print nothing but errors")


def main(arguments: argparse.Namespace) -> int:
    """Serves one flight of a station, as `aerodrake run SCENARIO --lcm` is one, in wall time."""
    from tqdm import tqdm

    from aerodrake.scenario.load import load_scenario

    scenario = load_scenario(arguments.scenario, overrides(arguments))

    from aerodrake.scenario.inputs import frozen
    from aerodrake.support.compiled import is_cold
    from aerodrake.support.errors import ProcessDied
    from aerodrake.support.garbage import frozen_garbage
    from aerodrake.support.interrupts import held_interrupts
    from aerodrake.wire.companion import Companion
    from aerodrake.wire.link import make_lcm

    say = (lambda line: None) if arguments.quiet else print
    lcm = make_lcm(arguments.lcm)
    if is_cold():
        say("note: equations are compiled first; this takes a minute, once on a machine")
    with frozen(scenario) as scenario:  # As the station's: copies are alike.
        companion = Companion(scenario, lcm, say)
    say(f"note: waits for a station at {arguments.lcm}")
    try:
        with (
            held_interrupts() as check,
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
                bar.total = max(bar.total, flown_s)  # How long it flies is the station's to say.
                bar.update(flown_s - bar.n)
                check()

            companion.serve(progress)
    finally:
        say(companion.service.line())
    if companion.service.fault:
        raise ProcessDied(companion.service.fault)
    return 0
