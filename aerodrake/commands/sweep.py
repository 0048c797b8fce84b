"""`aerodrake sweep SCENARIO`."""

from __future__ import annotations

import argparse
import os
import shlex
import sys

from aerodrake.commands.options import (
    add_output,
    add_scenario,
    new_folder,
    overrides,
    whole_number,
)
from aerodrake.support.errors import BadInput, ProcessDied

HELP = "fly a scenario many times, with other values of its keys"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares its arguments."""
    add_scenario(command)
    command.add_argument(
        "--trials",
        type=whole_number(1, 100_000),
        metavar="N",
        help="flights; default: the grid of all linspace(), once",
    )
    command.add_argument(
        "--vary",
        action="append",
        default=[],
        metavar="KEY=DIST",
        help="draws a dotted key for each trial from uniform(a,b), normal(m,s), choice(x,y,...), "
        "or spans a grid by linspace(a,b,n); may be given for several keys",
    )
    command.add_argument("--seed", metavar="N", help="of the sweep; default: the scenario's")
    engine = command.add_mutually_exclusive_group()
    engine.add_argument(
        "--jobs", type=whole_number(1, 1000), metavar="N", help="processes; default: the cores"
    )
    engine.add_argument("--scheduler", metavar="ADDRESS", help="of a Dask cluster that flies them")
    command.add_argument(
        "--resume", action="store_true", help="go on with the sweep in --out, or add trials to it"
    )
    add_output(command, "runs/SCENARIO-sweep-TIME; a finished sweep there is replaced as a whole")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario many times, with keys drawn from distributions or along grids.

    Each trial is a row of trials.jsonl as it ends. Interrupted, it goes on with --resume.
    """
    from tqdm import tqdm

    from aerodrake.scenario.load import load_scenario
    from aerodrake.scenario.rules import warnings

    if arguments.resume and not arguments.out:
        raise BadInput("--resume", "", "expected the folder of a sweep by --out DIR")
    scenario = load_scenario(arguments.scenario, overrides(arguments))

    from aerodrake.model.low_level.thrust_allocation import thrust_notes
    from aerodrake.model.residual.scenario_network import provenance_notes
    from aerodrake.support.compiled import is_cold
    from aerodrake.sweeps.cluster import cluster
    from aerodrake.sweeps.folder import FILES, sweep_folder
    from aerodrake.sweeps.loop import processes, sweep
    from aerodrake.sweeps.plan import Plan
    from aerodrake.sweeps.report import sweep_table, write_report
    from aerodrake.sweeps.trial import FAILURES

    plan = Plan.make(scenario, arguments.vary, arguments.trials)
    plan.check()
    target = arguments.out or new_folder(f"{scenario.name}-sweep")
    say = (lambda line: None) if arguments.quiet else print
    joints = len(scenario.vehicle.working_rad)
    known = (*provenance_notes(scenario, joints), *thrust_notes(scenario))
    for note in (*warnings(scenario), *known):
        say(f"note: {note}")
    if is_cold():
        say("note: equations are compiled first; this takes a minute, once on a machine")
    jobs = arguments.jobs or os.cpu_count() or 1
    address = arguments.scheduler
    engine = processes(jobs) if address is None else cluster(address)
    with engine as executor, sweep_folder(target, plan, arguments.resume) as folder:
        endings: dict[str, int] = {}
        try:
            with tqdm(
                total=plan.trials,
                initial=len(folder.recorded),
                desc=scenario.name,
                unit="trial",
                disable=arguments.quiet,
            ) as bar:

                def progress(row: dict) -> None:
                    reason = row["exit_reason"]
                    if reason != "completed":
                        endings[reason] = endings.get(reason, 0) + 1
                        bar.set_postfix(endings, refresh=False)
                    bar.update()

                sweep(folder, executor, progress)
        except (KeyboardInterrupt, ProcessDied):
            done = f"{len(folder.recorded)} of {plan.trials} trials are in {target}"
            print(f"aerodrake: {done}; to go on: {_resume(arguments, target)}", file=sys.stderr)
            raise
        summary = write_report(folder)
    say(sweep_table(summary))
    say(f"\n{target}: {', '.join(FILES)}")
    return 1 if any(summary["endings"].get(reason) for reason in FAILURES) else 0


def _resume(arguments: argparse.Namespace, target: object) -> str:
    """The command that goes on with an interrupted sweep."""
    words = ["aerodrake", "sweep", arguments.scenario]
    for option in ("set", "vary"):
        words += [word for value in getattr(arguments, option) for word in (f"--{option}", value)]
    for option in ("trials", "seed", "jobs", "scheduler"):
        value = getattr(arguments, option)
        if value is not None:
            words += [f"--{option}", str(value)]
    return shlex.join([*words, "--resume", "--out", str(target)])
