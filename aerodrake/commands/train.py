"""Command `aerodrake train [SCENARIO]`."""

import argparse
from pathlib import Path

from aerodrake.commands.options import add_jobs, add_output, add_scenario, load

HELP = "train the residual network"


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Declares the arguments of the command."""
    add_scenario(command, default="clover_paper")
    command.add_argument("--seed", metavar="N", help="override the scenario's seed")
    command.add_argument("--quick", action="store_true", help="fly a few short runs, as a test")
    add_jobs(command)
    add_output(command, "runs/train-SCENARIO or runs/train-quick-SCENARIO, which it resumes")


def main(arguments: argparse.Namespace) -> int:
    """Collects data, trains the residual network and evaluates it on held-out flights.

    An interrupted command resumes when it is run again.
    """
    scenario = load(arguments)

    from aerodrake.api.console import Console
    from aerodrake.api.jobs import checked_jobs
    from aerodrake.learning.collection_runs import paper_runs, quick_runs
    from aerodrake.learning.report import training_table
    from aerodrake.learning.train import CHECKPOINT, DATA, FIGURE, LOG, train_scenario
    from aerodrake.model.residual.training import TrainingConfig
    from aerodrake.scenario.inputs import frozen

    kind = "train-quick" if arguments.quick else "train"
    target = arguments.out or Path("runs", f"{kind}-{scenario.name}")
    runs = quick_runs() if arguments.quick else paper_runs()
    jobs, config = checked_jobs(arguments.jobs), TrainingConfig()
    with frozen(scenario) as scenario:
        evaluation = train_scenario(scenario, runs, config, target, jobs, arguments.quiet)
    files = ", ".join((CHECKPOINT, LOG, FIGURE, DATA))
    Console(arguments.quiet).say(f"{training_table(evaluation)}\n\n{target}: {files}")
    return 0
