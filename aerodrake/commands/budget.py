"""Command `aerodrake budget SCENARIO`."""

import argparse

from aerodrake.commands import options, study_options
from aerodrake.support.limits import SEEDS

HELP = "find what each flaw of sensors, actuators and environment costs"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    options.add_scenario(command)
    options.add_short_forms(command)
    command.add_argument(
        "--seeds",
        type=options.whole_number(*SEEDS),
        default=5,
        metavar="N",
        help="number of seeds, which count up from the scenario's; default: 5",
    )
    study_options.add_study(command, "budget", "seeds")


def main(arguments: argparse.Namespace) -> int:
    """Flies a scenario without flaws, with each flaw alone, with all, and without each of them.

    Each flight adds a row to trials.jsonl when it ends. --resume continues an interrupted budget.
    """
    study_options.check_resume(arguments, "budget")
    scenario = options.load(arguments)

    from aerodrake.api.budget import budget
    from aerodrake.api.console import Console
    from aerodrake.budgets.plan import BudgetPlan

    target = arguments.out or options.new_folder(f"{scenario.name}-budget")
    shared = study_options.study_arguments(arguments, target)
    with study_options.resumable(arguments, "budget", target, ("seeds", "seed", "duration")):
        result = budget(scenario, seeds=arguments.seeds, **shared)
    files = ", ".join(BudgetPlan.files.all)
    Console(arguments.quiet).say(f"{result}\n\n{target}: {files}")
    return 0
