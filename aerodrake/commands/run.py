"""`aerodrake run SCENARIO`."""

from __future__ import annotations

import argparse
from contextlib import nullcontext

from aerodrake.commands.options import (
    FLIGHT_BAR,
    LCM_URL,
    add_output,
    add_scenario,
    new_folder,
    overrides,
)

HELP = "fly a scenario"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    add_scenario(command)
    command.add_argument("--seed", metavar="N", help="overrides the scenario's seed")
    command.add_argument("--duration", metavar="S", help="reference time to fly, in s")
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

    from aerodrake.scenario_file import load_scenario
    from aerodrake.scenario_rules import warnings

    scenario = load_scenario(arguments.scenario, overrides(arguments))
    target = arguments.out or new_folder(scenario.name)

    from aerodrake.compiled import is_cold
    from aerodrake.flight_folder import fly_into
    from aerodrake.inputs import frozen
    from aerodrake.interrupts import held_interrupts
    from aerodrake.model.scenario_network import provenance_notes
    from aerodrake.model.thrust_allocation import thrust_notes
    from aerodrake.replay import write_replay
    from aerodrake.report import table
    from aerodrake.run_folder import run_folder
    from aerodrake.simulate import Flight

    say = (lambda line: None) if arguments.quiet else print
    joints = len(scenario.vehicle.working_rad)
    with frozen(scenario) as scenario:
        known = (*provenance_notes(scenario, joints), *thrust_notes(scenario))
        for note in (*warnings(scenario), *known):
            say(f"note: {note}")
        if is_cold():
            say("note: equations are compiled first; this takes a minute, once on a machine")
        link = None
        if arguments.lcm:
            from aerodrake.garbage import frozen_garbage
            from aerodrake.remote_coordinator import make_station_link
            from aerodrake.wire import make_lcm

            link = make_station_link(scenario, make_lcm(arguments.lcm), say)
        flight = Flight(scenario, link)
        if link:
            say(f"note: waits in trim for a coordinator at {arguments.lcm}")
        with (
            frozen_garbage() if link else nullcontext(),
            held_interrupts() as check,
            run_folder(target) as folder,
            tqdm(
                total=scenario.settle_s + scenario.duration,
                desc=scenario.name,
                unit="s",
                disable=arguments.quiet,
                bar_format=FLIGHT_BAR,
            ) as bar,
        ):

            def progress(simulated_s: float) -> None:
                bar.update(simulated_s - bar.n)
                check()  # An interrupt ends the flight, not what is made of it.

            title = f"{scenario.name}, seed {scenario.seed}"
            summary, log = fly_into(folder, flight, title, progress, rate=1.0 if link else 0.0)
            bar.close()
            write_replay(log, scenario, folder / "replay.html")
    say(table(summary, scenario.reference.kind))
    say(f"\n{target}: summary.json, log.npz, scenario.yaml, tracking.png, replay.html")
    return 0 if log.exit_reason == "completed" else 1
