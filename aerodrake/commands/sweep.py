"""Command `aerodrake sweep SCENARIO`."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from typing import TYPE_CHECKING

from aerodrake.commands import options
from aerodrake.support.errors import BadInput, ProcessDied

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from aerodrake.sweeps.folder import SweepFolder

HELP = "fly a scenario many times with varied keys"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    command.add_argument(
        "--trials",
        type=options.whole_number(1, 100_000),
        metavar="N",
        help="number of flights; default: one for each point of the grid of all linspace()",
    )
    command.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=DIST",
        help="draw a dotted key for each trial from uniform(a,b), normal(m,s) or choice(x,y,...), "
        "or vary it on a grid with linspace(a,b,n); may be given several times",
    )
    command.add_argument(
        "--seed", metavar="N", help="seed of the sweep; default: the scenario's seed"
    )
    engine = command.add_mutually_exclusive_group()
    engine.add_argument(
        "--jobs",
        type=options.whole_number(1, 1000),
        metavar="N",
        help="number of concurrent processes; default: the number of cores",
    )
    engine.add_argument("--scheduler", metavar="ADDRESS", help="fly the trials on a Dask cluster")
    command.add_argument(
        "--resume", action="store_true", help="continue the sweep in --out, or add trials to it"
    )
    options.add_output(command, "runs/SCENARIO-sweep-TIME; replaces a finished sweep in it")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario many times, with keys drawn from distributions or on grids.

    Each trial adds a row to trials.jsonl when it ends. --resume continues an interrupted sweep.
    """
    if arguments.resume and not arguments.out:
        raise BadInput("--resume", "", "expected --out DIR with the folder of a sweep")
    scenario = options.load(arguments)

    from aerodrake.sweeps.cluster import cluster
    from aerodrake.sweeps.folder import FILES, sweep_folder
    from aerodrake.sweeps.loop import processes
    from aerodrake.sweeps.plan import Plan
    from aerodrake.sweeps.report import sweep_table, write_report
    from aerodrake.sweeps.trial import FAILURES

    plan = Plan.make(scenario, arguments.vary, arguments.trials)
    plan.check()
    target = arguments.out or options.new_folder(f"{scenario.name}-sweep")
    say = options.printer(arguments)
    options.print_notes(say, scenario)
    jobs = arguments.jobs or os.cpu_count() or 1
    address = arguments.scheduler
    engine = processes(jobs) if address is None else cluster(address)
    with engine as executor, sweep_folder(target, plan, arguments.resume) as folder:
        try:
            _fly(arguments, folder, executor)
        except (KeyboardInterrupt, ProcessDied):
            done = f"{len(folder.recorded)} of {plan.trials} trials are in {target}"
            again = _resume(arguments, target)
            print(f"aerodrake: {done}; continue with: {again}", file=sys.stderr)
            raise
        summary = write_report(folder)
    say(sweep_table(summary))
    say(f"\n{target}: {', '.join(FILES)}")
    return 1 if any(summary["endings"].get(reason) for reason in FAILURES) else 0


def _fly(arguments: argparse.Namespace, folder: SweepFolder, executor: Executor) -> None:
    """Flies the trials that have no row yet, with a progress bar."""
    from aerodrake.sweeps.loop import sweep

    endings: dict[str, int] = {}
    name, trials = folder.plan.scenario.name, folder.plan.trials
    bar = options.progress_bar(arguments, name, trials, "trial", initial=len(folder.recorded))
    with bar:

        def progress(row: dict) -> None:
            reason = row["exit_reason"]
            if reason != "completed":
                endings[reason] = endings.get(reason, 0) + 1
                bar.set_postfix(endings, refresh=False)
            bar.update()

        sweep(folder, executor, progress)


def _resume(arguments: argparse.Namespace, target: object) -> str:
    """Returns the command that continues an interrupted sweep."""
    words = ["aerodrake", "sweep", arguments.scenario]
    for option in ("set", "vary"):
        words += [word for value in getattr(arguments, option) for word in (f"--{option}", value)]
    for option in ("trials", "seed", "jobs", "scheduler"):
        value = getattr(arguments, option)
        if value is not None:
            words += [f"--{option}", str(value)]
    return shlex.join([*words, "--resume", "--out", str(target)])
