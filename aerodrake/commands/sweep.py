"""Command `aerodrake sweep SCENARIO`."""

import argparse
from collections.abc import Iterator

from aerodrake.commands import options, study_options
from aerodrake.support.errors import BadInput
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
    study_options.add_study(command, "sweep", "trials")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario many times, with keys drawn from distributions or on grids.

    Each trial adds a row to trials.jsonl when it ends. --resume continues an interrupted sweep.
    """
    study_options.check_resume(arguments, "sweep")
    scenario = options.load(arguments)
    vary = dict(_distributions(arguments.vary))

    from aerodrake.api.console import Console
    from aerodrake.api.sweep import sweep
    from aerodrake.sweeps.plan import Plan
    from aerodrake.sweeps.trial import FAILURES

    target = arguments.out or options.new_folder(f"{scenario.name}-sweep")
    shared = study_options.study_arguments(arguments, target)
    with study_options.resumable(arguments, "sweep", target, ("vary", "trials", "seed")):
        result = sweep(scenario, vary=vary, trials=arguments.trials, **shared)
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
