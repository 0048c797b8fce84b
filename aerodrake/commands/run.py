"""Command `aerodrake run SCENARIO`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aerodrake.commands.options import (
    FLIGHT_BAR,
    LCM_URL,
    LIVE_BAR,
    add_output,
    add_scenario,
    new_folder,
    number_in,
    overrides,
    print_notes,
    printer,
)
from aerodrake.support.errors import BadInput

if TYPE_CHECKING:
    from aerodrake.flight.log import FlightLog
    from aerodrake.scenario import Scenario

HELP = "fly a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    add_scenario(command)
    command.add_argument("--seed", metavar="N", help="override the scenario's seed")
    command.add_argument(
        "--duration", metavar="S", help="override the duration, in s of reference time"
    )
    command.add_argument(
        "--live", action="store_true", help="show the flight in a browser in real time"
    )
    command.add_argument(
        "--rate",
        type=number_in(0.01, 1000.0),
        metavar="R",
        help="with --live: ratio of simulated time to wall time; default: 1",
    )
    command.add_argument(
        "--lcm",
        nargs="?",
        const=LCM_URL,
        metavar="URL",
        help="fly in real time with `aerodrake coordinator` in another process, over LCM at URL; "
        f"default: {LCM_URL}",
    )
    add_output(command, "runs/SCENARIO-TIME; replaces an earlier run in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario, writes its results and prints a table."""
    from aerodrake.scenario.load import load_scenario

    if arguments.rate is not None and not arguments.live:
        raise BadInput("--rate", "", "expected --live; other flights do not run at a given rate")
    if arguments.rate is not None and arguments.lcm:
        raise BadInput("--rate", "", "expected no --lcm, which flies in real time")
    scenario = load_scenario(arguments.scenario, overrides(arguments))
    target = arguments.out or new_folder(scenario.name)

    from aerodrake.reports.flight_table import table
    from aerodrake.scenario.inputs import frozen

    say = printer(arguments)
    with frozen(scenario) as scenario:
        print_notes(say, scenario)
        summary, log = _fly(arguments, scenario, target, say)
    say(table(summary, scenario.reference.kind))
    say(f"\n{target}: summary.json, log.npz, scenario.yaml, tracking.png, replay.html, report.html")
    return 0 if log.exit_reason == "completed" else 1


def _fly(
    arguments: argparse.Namespace, scenario: Scenario, target: Path, say: Callable[[str], None]
) -> tuple[dict[str, Any], FlightLog]:
    """Flies the scenario and writes all files of the results."""
    from tqdm import tqdm

    from aerodrake.flight.simulate import FlightSimulation
    from aerodrake.reports.flight_folder import fly_into
    from aerodrake.reports.flight_page import report_page
    from aerodrake.reports.replay import replay_page
    from aerodrake.support.garbage import frozen_garbage
    from aerodrake.support.interrupts import deferred_interrupts
    from aerodrake.support.run_folder import run_folder

    link = view = None
    if arguments.lcm:
        from aerodrake.wire.link import make_lcm
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
    with (
        view or nullcontext(),
        deferred_interrupts() as check,
        frozen_garbage() if link else nullcontext(),
        run_folder(target) as folder,
        tqdm(
            total=scenario.settle_s + scenario.duration,
            desc=scenario.name,
            unit="s",
            disable=arguments.quiet,
            bar_format=FLIGHT_BAR if view is None else LIVE_BAR,
        ) as bar,
    ):

        def progress(simulated_s: float) -> None:
            if view is not None:
                bar.set_postfix_str(view.line(), refresh=False)
            bar.update(simulated_s - bar.n)
            check()  # An interrupt ends the flight; its results are still written.

        attach = view.attach if view is not None else lambda flight, simulator: None
        title = f"{scenario.name}, seed {scenario.seed}"
        summary, log = fly_into(folder, flight, title, progress, rate, attach)
        bar.close()
        replay = replay_page(log, scenario)
        (folder / "replay.html").write_text(replay, encoding="utf-8")
        page = report_page(flight, summary, log, replay, folder, target)
        (folder / "report.html").write_text(page, encoding="utf-8")
    return summary, log
