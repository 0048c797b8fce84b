"""Command `aerodrake identify [SCENARIO]`."""

import argparse
import shlex
from pathlib import Path

from aerodrake.commands import options
from aerodrake.scenario.edit import check_replaceable, replace_numbers
from aerodrake.scenario.inputs import frozen
from aerodrake.support.errors import BadInput
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.support.run_folder import run_folder

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
    if arguments.write:
        if arguments.set:
            raise BadInput("--write", "", "expected no --set, since K_B is written to the file")
        check_replaceable(Path(scenario.source), "model.k_b")
    target = arguments.out or options.new_folder(f"identify-{scenario.name}")

    from aerodrake.identification import report
    from aerodrake.identification.identify import DURATION_S, FLIGHTS, identify

    say = options.printer(arguments)
    settings = [f"--set={assignment}" for assignment in arguments.set]
    command = shlex.join(["aerodrake", "identify", arguments.scenario, *settings])
    with frozen(scenario) as copied, run_folder(target, report.RESULTS) as folder:
        name = f"identify {scenario.name}"
        with options.flight_bar(arguments, name, FLIGHTS * DURATION_S) as bar:
            identification = identify(copied, arguments.jobs, progress=bar.update)
        with deferred_interrupts():
            report.write(identification, command, folder)
    with deferred_interrupts():
        report.draw(identification, target)
    say(f"{target}: {', '.join(report.FILES)}")
    if arguments.write:
        replace_numbers(Path(scenario.source), "model.k_b", identification.k_b)
        say(f"{scenario.source}: model.k_b replaced")
    say(f"\n{report.table(identification)}")
    return 0
