"""`aerodrake run SCENARIO`."""

from __future__ import annotations

import argparse
import sys
from contextlib import nullcontext

from aerodrake.commands.options import (
    FLIGHT_BAR,
    LCM_URL,
    LIVE_BAR,
    add_output,
    add_scenario,
    new_folder,
    number_in,
    overrides,
)
from aerodrake.support.errors import BadInput

HELP = "fly a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    add_scenario(command)
    command.add_argument("--seed", metavar="N", help="overrides the scenario's seed")
    command.add_argument("--duration", metavar="S", help="reference time to fly, in s")
    command.add_argument(
        "--live", action="store_true", help="show it in a browser while it flies, at real time"
    )
    command.add_argument(
        "--rate",
        type=number_in(0.01, 1000.0),
        metavar="R",
        help="with --live: simulated time over wall time; default: 1",
    )
    command.add_argument(
        "--lcm",
        nargs="?",
        const=LCM_URL,
        metavar="URL",
        help="fly in real time, by an `aerodrake coordinator` of another process, over LCM at URL; "
        f"default: {LCM_URL}",
    )
    add_output(command, "runs/SCENARIO-TIME; an earlier run there is replaced as a whole")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario; writes its results and prints the table."""
    from tqdm import tqdm

    from aerodrake.scenario.load import load_scenario
    from aerodrake.scenario.rules import warnings

    if arguments.rate is not None and not arguments.live:
        raise BadInput("--rate", "", "expected --live beside it: other flights take what they take")
    if arguments.rate is not None and arguments.lcm:
        raise BadInput("--rate", "", "expected none beside --lcm, where flights are in real time")
    scenario = load_scenario(arguments.scenario, overrides(arguments))
    target = arguments.out or new_folder(scenario.name)

    from aerodrake.flight.simulate import FlightSimulation
    from aerodrake.model.low_level.thrust_allocation import thrust_notes
    from aerodrake.model.residual.scenario_network import provenance_notes
    from aerodrake.reports.flight_folder import fly_into
    from aerodrake.reports.flight_page import report_page
    from aerodrake.reports.flight_table import table
    from aerodrake.reports.replay import replay_page
    from aerodrake.scenario.inputs import frozen
    from aerodrake.support.compiled import is_cold
    from aerodrake.support.interrupts import held_interrupts
    from aerodrake.support.run_folder import run_folder

    say = (lambda line: None) if arguments.quiet else print
    joints = len(scenario.vehicle.working_rad)
    with frozen(scenario) as scenario:
        known = (*provenance_notes(scenario, joints), *thrust_notes(scenario))
        for note in (*warnings(scenario), *known):
            say(f"note: {note}")
        if is_cold():
            say("note: equations are compiled first; this takes a minute, once on a machine")
        link = view = None
        if arguments.lcm:
            from aerodrake.support.garbage import frozen_garbage
            from aerodrake.wire.link import make_lcm
            from aerodrake.wire.remote_coordinator import make_station_link

            link = make_station_link(scenario, make_lcm(arguments.lcm), say)
        rate = arguments.rate or 1.0 if arguments.live or link else 0.0
        if arguments.live:
            from aerodrake.reports.live import LiveView

            view = LiveView(scenario, rate)
            print(f"watch it at {view.url}", file=sys.stderr)
        flight = FlightSimulation(scenario, link=link)
        if link:
            say(f"note: waits in trim for a coordinator at {arguments.lcm}")
        with (
            view or nullcontext(),
            held_interrupts() as check,
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
                check()  # An interrupt ends the flight, not what is made of it.

            attach = view.attach if view is not None else lambda flight, simulator: None
            title = f"{scenario.name}, seed {scenario.seed}"
            summary, log = fly_into(folder, flight, title, progress, rate, attach)
            bar.close()
            replay = replay_page(log, scenario)
            (folder / "replay.html").write_text(replay, encoding="utf-8")
            page = report_page(flight, summary, log, replay, folder, target)
            (folder / "report.html").write_text(page, encoding="utf-8")
    say(table(summary, scenario.reference.kind))
    say(f"\n{target}: summary.json, log.npz, scenario.yaml, tracking.png, replay.html, report.html")
    return 0 if log.exit_reason == "completed" else 1
