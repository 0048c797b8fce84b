"""Options that the commands of studies, sweeps and error budgets, share."""

import argparse
import json
import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from aerodrake.commands import options
from aerodrake.support.errors import BadInput, ProcessDied


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


def study_arguments(arguments: argparse.Namespace, target: Path) -> dict[str, Any]:
    """Returns the arguments that the functions of studies share; `target` is the folder."""
    shared = {key: getattr(arguments, key) for key in ("resume", "jobs", "scheduler", "quiet")}
    return {"out": target, **shared}


@contextmanager
def resumable(
    arguments: argparse.Namespace, kind: str, target: Path, own: tuple[str, ...]
) -> Iterator[None]:
    """Prints how to resume a study that does not end in this context, with the recorded trials.

    Args:
        arguments: Of the command.
        kind: Name of the command.
        target: Folder of the study.
        own: Names of its options with values, beside those that all studies have.
    """
    try:
        yield
    except (KeyboardInterrupt, ProcessDied):
        _say_how_to_resume(arguments, kind, target, own)
        raise


def _say_how_to_resume(
    arguments: argparse.Namespace, kind: str, target: Path, own: tuple[str, ...]
) -> None:
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
