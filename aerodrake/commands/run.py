"""Command `aerodrake run SCENARIO`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerodrake.commands import options
from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import frozen
from aerodrake.support.errors import BadInput
from aerodrake.support.garbage import frozen_garbage
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.run_folder import check_target, run_folder

if TYPE_CHECKING:
    from aerodrake.flight.log import FlightLog

HELP = "fly a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    command.add_argument("--seed", metavar="N", help="override the scenario's seed")
    command.add_argument(
        "--duration", metavar="S", help="override the duration, in s of reference time"
    )
    command.add_argument(
        "--live", action="store_true", help="show the flight in a browser in real time"
    )
    command.add_argument(
        "--rate",
        type=options.number_in(0.01, 1000.0),
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
        raise BadInput("--rate", "", "expected --live; other flights do not run at a given rate")
    if arguments.rate is not None and arguments.lcm:
        raise BadInput("--rate", "", "expected no --lcm, which flies in real time")
    scenario = options.load(arguments)
    target = arguments.out or options.new_folder(scenario.name)
    check_target(target)

    from aerodrake.reports.flight_table import table

    say = options.printer(arguments)
    with frozen(scenario) as scenario:
        options.print_notes(say, scenario)
        summary, log = _fly(arguments, scenario, target, say)
    say(table(summary, scenario.reference.kind))
    say(f"\n{target}: summary.json, log.npz, scenario.yaml, tracking.png, replay.html, report.html")
    return 0 if log.exit_reason == "completed" else 1


def _fly(
    arguments: argparse.Namespace, scenario: Scenario, target: Path, say: Callable[[str], None]
) -> tuple[dict[str, Any], FlightLog]:
    """Flies the scenario and writes all files of the results."""
    from aerodrake.flight.simulate import FlightSimulation
    from aerodrake.reports.flight_folder import draw_pages, draw_tracking, fly_into

    link = view = None
    if arguments.lcm:
        from aerodrake.wire.interface import make_lcm
        from aerodrake.wire.remote_coordinator import make_station_link

        link = make_station_link(scenario, make_lcm(arguments.lcm), say)
    rate = arguments.rate or 1.0 if arguments.live or link else 0.0
    flight = FlightSimulation(scenario, link=link)
    if arguments.live:
        from aerodrake.reports.live import LiveView

        view = LiveView(flight, rate)
        print(f"watch it at {view.url}", file=sys.stderr)
    if link:
        say(f"note: waiting in trim for a coordinator at {arguments.lcm}")
    form = options.FLIGHT_BAR if view is None else options.LIVE_BAR
    total_s = scenario.settle_s + scenario.duration
    with view or nullcontext(), deferred_interrupts() as check:
        with (
            frozen_garbage() if link else nullcontext(),
            run_folder(target) as folder,
            options.flight_bar(arguments, scenario.name, total_s, form) as bar,
        ):

            def progress(simulated_s: float) -> None:
                if view is not None:
                    bar.set_postfix_str(view.line(), refresh=False)
                bar.update(simulated_s - bar.n)
                check()  # An interrupt ends the flight; its results are still written.

            attach = view.attach if view is not None else lambda flight, simulator: None
            summary, log = fly_into(folder, flight, progress, rate, attach)
        # The results are in their place, whatever happens to the drawings.
        draw_tracking(target, scenario, log, f"{scenario.name}, seed {scenario.seed}")
        draw_pages(target, flight, summary, log)
    return summary, log
