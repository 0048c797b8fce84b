"""Options that the commands of studies, sweeps and error budgets, share."""

import argparse
import json
import shlex
import sys
from pathlib import Path

from aerodrake.commands import options
from aerodrake.support.errors import BadInput


def add_study(command: argparse.ArgumentParser, kind: str, items: str) -> None:
    """Adds the options on executor, resumption and output.

    Args:
        command: Parser of the command.
        kind: `sweep` or `budget`.
        items: `trials` or `seeds`, which can be added to a study.
    """
    engine = command.add_mutually_exclusive_group()
    options.add_jobs(engine)
    engine.add_argument("--scheduler", metavar="ADDRESS", help="fly the trials on a Dask cluster")
    command.add_argument(
        "--resume",
        action="store_true",
        help=f"continue the {kind} in --out, or add {items} to it",
    )
    options.add_output(command, f"runs/SCENARIO-{kind}-TIME; replaces a finished {kind} in it")


def check_resume(arguments: argparse.Namespace, kind: str) -> None:
    """Raises BadInput if --resume names no folder."""
    if arguments.resume and not arguments.out:
        raise BadInput("resume", "", f"expected --out DIR with the folder of a {kind}")


def say_how_to_resume(
    arguments: argparse.Namespace, kind: str, target: Path, own: tuple[str, ...]
) -> None:
    """Prints the number of recorded trials, and the command that continues the study.

    Args:
        arguments: Of the command.
        kind: Name of the command.
        target: Folder of the study.
        own: Names of its options with values, beside those that all studies have.
    """
    from aerodrake.sweeps.folder import read_rows
    from aerodrake.sweeps.study_files import StudyFiles

    plan = target / StudyFiles(kind).plan
    if not plan.is_file():
        return  # No trial was flown.
    trials = json.loads(plan.read_text())["trials"]
    done = f"{len(list(read_rows(target)))} of {trials} trials are in {target}"
    words = ["aerodrake", kind, arguments.scenario]
    for option in ("set", *own, "jobs", "scheduler"):
        value = getattr(arguments, option)
        values = value if isinstance(value, list) else [value] * (value is not None)
        words += [word for item in values for word in (f"--{option}", str(item))]
    again = shlex.join([*words, "--resume", "--out", str(target)])
    print(f"aerodrake: {done}; continue with: {again}", file=sys.stderr)
