"""Command `aerodrake sweep SCENARIO`."""

import argparse
import json
import shlex
import sys
from collections.abc import Iterator
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.errors import BadInput, ProcessDied
from aerodrake.support.limits import TRIALS

HELP = "fly a scenario many times with varied keys"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    command.add_argument(
        "--trials",
        type=options.whole_number(*TRIALS),
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
    options.add_jobs(engine)
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
        raise BadInput("resume", "", "expected --out DIR with the folder of a sweep")
    scenario = options.load(arguments)
    vary = dict(_distributions(arguments.vary))

    from aerodrake.api.console import Console
    from aerodrake.api.sweep import sweep
    from aerodrake.sweeps.plan import Plan
    from aerodrake.sweeps.trial import FAILURES

    target = arguments.out or options.new_folder(f"{scenario.name}-sweep")
    try:
        result = sweep(
            scenario,
            vary=vary,
            trials=arguments.trials,
            out=target,
            resume=arguments.resume,
            jobs=arguments.jobs,
            scheduler=arguments.scheduler,
            quiet=arguments.quiet,
        )
    except (KeyboardInterrupt, ProcessDied):
        _say_how_to_resume(arguments, target)
        raise
    Console(arguments.quiet).say(f"{result}\n\n{target}: {', '.join(Plan.files.all)}")
    return 1 if any(result.summary["endings"].get(reason) for reason in FAILURES) else 0


def _distributions(assignments: list[str]) -> Iterator[tuple[str, str]]:
    """Yields the dotted key and the distribution of each `KEY=DIST`."""
    seen = set()
    for text in assignments:
        key, equals, distribution = text.partition("=")
        key = key.strip()
        if not key or not equals:
            raise BadInput("vary", "", f"expected dotted.key=distribution, got '{text}'")
        if key in seen:
            raise BadInput("vary", key, "expected each key once")
        seen.add(key)
        yield key, distribution


def _say_how_to_resume(arguments: argparse.Namespace, target: Path) -> None:
    """Prints the number of recorded trials, and the command that continues the sweep."""
    from aerodrake.sweeps.folder import read_rows
    from aerodrake.sweeps.plan import Plan

    if not (target / Plan.files.plan).is_file():
        return  # No trial was flown.
    trials = json.loads((target / Plan.files.plan).read_text())["trials"]
    done = f"{len(list(read_rows(target)))} of {trials} trials are in {target}"
    words = ["aerodrake", "sweep", arguments.scenario]
    for option in ("set", "vary"):
        words += [word for value in getattr(arguments, option) for word in (f"--{option}", value)]
    for option in ("trials", "seed", "jobs", "scheduler"):
        value = getattr(arguments, option)
        if value is not None:
            words += [f"--{option}", str(value)]
    again = shlex.join([*words, "--resume", "--out", str(target)])
    print(f"aerodrake: {done}; continue with: {again}", file=sys.stderr)
