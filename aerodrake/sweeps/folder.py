"""The folder of a sweep: its plan, a row for each trial that has ended, and what came of them."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerodrake.scenario.load import load_scenario, save_scenario
from aerodrake.support.errors import BadInput
from aerodrake.support.files import write_whole
from aerodrake.support.run_folder import run_folder
from aerodrake.sweeps.match import PLAN, SCENARIO, check_same
from aerodrake.sweeps.plan import Plan

ROWS, TIMINGS = "trials.jsonl", "timings.jsonl"
SUMMARY, FIGURE = "sweep_summary.json", "sweep.png"
FILES = (SCENARIO, PLAN, ROWS, TIMINGS, SUMMARY, FIGURE)
"""What a finished sweep leaves behind; an unfinished one has no summary."""


class SweepFolder:
    """Where the rows of a sweep go, one after another.

    Attributes:
        path: The folder.
        plan: What is flown: the scenario is the folder's own.
        flown: The trials that have a row.
    """

    def __init__(self, path: Path, plan: Plan):
        self.path = path
        self.plan = replace(plan, scenario=load_scenario(str(path / SCENARIO)))
        self.flown: set[int] = set()
        for name in (ROWS, TIMINGS):
            _drop_torn_line(path / name)
        for number, row in enumerate(read_rows(path), 1):
            if row["trial"] in self.flown or not 0 <= row["trial"] < plan.trials:
                raise BadInput(path / ROWS, "", f"line {number}: expected each trial once")
            self.flown.add(row["trial"])

    def append(self, row: dict[str, Any], timing: dict[str, Any] | None) -> None:
        """Writes a trial's row to the disk, and how long it took.

        Raises:
            BadInput: if it cannot.
        """
        with writing(self.path):
            _append(self.path / ROWS, row)
            self.flown.add(row["trial"])
            if timing:
                _append(self.path / TIMINGS, timing)


@contextmanager
def sweep_folder(target: Path, plan: Plan, resumes: bool) -> Iterator[SweepFolder]:
    """The folder of a sweep, which nobody else writes to meanwhile.

    A finished sweep in it is replaced as a whole, at once. One that is not finished goes
    on if that is what is asked for; with as many trials as before, or more.

    Args:
        target: Where it is to be.
        plan: What is to be flown.
        resumes: Whether there is one, to go on.

    Raises:
        BadInput: if `target` cannot be written, holds something else, is in use by
            another sweep, or has another plan.
    """
    with contextlib.ExitStack() as locks:
        with writing(target):
            if resumes:
                _lock(target, locks)
                check_same(target, plan)
                _reopen(target, plan)
            else:
                _begin(target, plan, locks)
            folder = SweepFolder(target, plan)
        yield folder


def read_rows(path: Path) -> Iterator[dict[str, Any]]:
    """The rows of a sweep's folder, in the order in which its trials ended.

    Raises:
        BadInput: if one is none.
    """
    with open(path / ROWS, encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            try:
                row = json.loads(line)
                is_row = type(row["trial"]) is int and isinstance(row["exit_reason"], str)
                if not is_row or not _are_figures(row.get("error", {})):
                    raise ValueError
            except (ValueError, KeyError, TypeError, RecursionError):
                raise BadInput(path / ROWS, "", f"line {number}: expected a trial's row") from None
            yield row


def _are_figures(error: object) -> bool:
    """Whether it is what rows have as `error`: numbers by name, or none."""
    return isinstance(error, dict) and all(
        figure is None or type(figure) in (int, float) for figure in error.values()
    )


def _begin(target: Path, plan: Plan, locks: contextlib.ExitStack) -> None:
    """A new sweep's folder, in the place of a finished one if there is one."""
    is_new = not target.exists()
    target.mkdir(parents=True, exist_ok=True)
    try:
        with contextlib.ExitStack() as earlier:
            _lock(target, earlier)
            if (target / PLAN).is_file() and not (target / SUMMARY).is_file():
                message = f"{target} holds a sweep that is not finished; --resume goes on with it"
                raise BadInput("--out", "", message)
            with run_folder(target, FILES) as folder:
                save_scenario(plan.scenario, folder)
                (folder / PLAN).write_text(_plan_text(plan), encoding="utf-8")
                for name in (ROWS, TIMINGS):
                    (folder / name).touch()
                # Before it has its place, so that nobody comes in between.
                _lock(folder, locks)
    except BaseException:
        if is_new:
            with contextlib.suppress(OSError):  # Unless there is something in it.
                target.rmdir()
        raise


def _reopen(target: Path, plan: Plan) -> None:
    if json.loads((target / PLAN).read_text())["trials"] < plan.trials:
        for name in (SUMMARY, FIGURE):
            (target / name).unlink(missing_ok=True)
        write_whole(target / PLAN, _plan_text(plan).encode())


def _plan_text(plan: Plan) -> str:
    return json.dumps(plan.as_mapping(), indent=2) + "\n"


@contextmanager
def writing(target: Path) -> Iterator[None]:
    """Within it a folder that cannot be written is bad input."""
    try:
        yield
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput("--out", "", f"cannot write {target}: {reason}") from None


def _lock(folder: Path, locks: contextlib.ExitStack) -> None:
    """Until `locks` are closed, or this process ends."""
    if not folder.is_dir():
        raise BadInput("--resume", "", f"expected the folder of a sweep, got {folder}")
    lock = os.open(folder, os.O_RDONLY)
    locks.callback(os.close, lock)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BadInput("--out", "", f"another sweep writes to {folder}") from None
    except OSError:
        return  # Of a file system without locks.
    if not os.path.samestat(os.fstat(lock), os.stat(folder)):
        raise BadInput("--out", "", f"another sweep writes to {folder}")


def _append(path: Path, row: dict[str, Any]) -> None:
    line = json.dumps(row, allow_nan=False, ensure_ascii=False) + "\n"
    with open(path, "ab") as file:
        file.write(line.encode())
        file.flush()
        os.fsync(file.fileno())


def _drop_torn_line(path: Path) -> None:
    """The last one, if its process was killed while it wrote it."""
    with open(path, "rb+") as file:
        file.truncate(sum(len(line) for line in file if line.endswith(b"\n")))
