"""Folder of a sweep: its plan, a row for each trial that has ended, and the results."""

import contextlib
import fcntl
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

from aerodrake.flight.summary import to_json
from aerodrake.scenario.load import load_scenario, save_scenario
from aerodrake.support.errors import BadInput, writing
from aerodrake.support.files import write_atomically
from aerodrake.support.run_folder import run_folder
from aerodrake.sweeps.match import check_same
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS, SCENARIO, TIMINGS


class SweepFolder:
    """Folder to which the rows of a sweep are appended.

    Attributes:
        path: Path of the folder.
        plan: Plan of the sweep, with the scenario that the folder contains.
        recorded: Indices of the trials that have a row.
    """

    def __init__(self, path: Path, plan: Plan):
        self.path = path
        self.plan = replace(plan, scenario=load_scenario(str(path / SCENARIO)))
        self.recorded: set[int] = set()
        for name in (ROWS, TIMINGS):
            _drop_torn_line(path / name)
        for number, row in enumerate(read_rows(path), 1):
            if row["trial"] in self.recorded or not 0 <= row["trial"] < plan.trials:
                raise BadInput(path / ROWS, "", f"line {number}: expected each trial once")
            self.recorded.add(row["trial"])

    def append(self, row: dict[str, Any], timing: dict[str, Any] | None) -> None:
        """Writes the row and the timing of a trial to the disk.

        Raises:
            BadInput: if they cannot be written.
        """
        with writing(self.path):
            _append(self.path / ROWS, row)
            self.recorded.add(row["trial"])
            if timing:
                _append(self.path / TIMINGS, timing)


@contextmanager
def sweep_folder(target: Path, plan: Plan, resumes: bool) -> Iterator[SweepFolder]:
    """Yields the folder of a sweep, locked against other sweeps.

    Without `resumes`, a finished sweep in the folder is replaced as a whole. With it, the sweep in
    the folder is resumed, with the same number of trials or more.

    Raises:
        BadInput: if `target` cannot be written, contains other files, is in use by another
            sweep, or has another plan.
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
    """Yields the rows of a sweep's folder, in the order in which its trials ended.

    Raises:
        BadInput: if a line is not a row.
    """
    with open(path / ROWS, encoding="utf-8", errors="replace") as lines:
        for number, line in enumerate(lines, 1):
            try:
                row = json.loads(line)
                is_row = type(row["trial"]) is int and isinstance(row["exit_reason"], str)
                kinds = {*map(type, row.get("error", {}).values())}
                if not is_row or kinds - {int, float, type(None)}:
                    raise ValueError
            except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
                raise BadInput(path / ROWS, "", f"line {number}: expected a trial's row") from None
            yield row


def _begin(target: Path, plan: Plan, locks: contextlib.ExitStack) -> None:
    """Creates the folder of a new sweep, or replaces that of a finished one."""
    is_new, files = not target.exists(), plan.files
    target.mkdir(parents=True, exist_ok=True)
    try:
        with contextlib.ExitStack() as earlier:
            _lock(target, earlier)
            if (target / files.plan).is_file() and not (target / files.summary).is_file():
                unfinished = f"contains an unfinished {files.kind}; `resume` continues it"
                raise BadInput(target, "", unfinished)
            with run_folder(target, files.results) as folder:
                save_scenario(plan.scenario, folder)
                (folder / files.plan).write_text(to_json(plan.as_mapping()), encoding="utf-8")
                for name in (ROWS, TIMINGS):
                    (folder / name).touch()
                # Before the folder gets its name, so that no other sweep can lock it first.
                _lock(folder, locks)
    except BaseException:
        if is_new:
            with contextlib.suppress(OSError):  # If it is not empty.
                target.rmdir()
        raise


def _reopen(target: Path, plan: Plan) -> None:
    files = plan.files
    if json.loads((target / files.plan).read_text())["trials"] < plan.trials:
        for name in (files.summary, files.figure):
            (target / name).unlink(missing_ok=True)
        write_atomically(target / files.plan, to_json(plan.as_mapping()).encode())


def _lock(folder: Path, locks: contextlib.ExitStack) -> None:
    """Locks the folder until `locks` are closed or this process ends."""
    if not folder.is_dir():
        raise BadInput("resume", "", f"expected the folder of a sweep, got {folder}")
    lock = os.open(folder, os.O_RDONLY)
    locks.callback(os.close, lock)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BadInput(folder, "", "another sweep writes to it") from None
    except OSError:
        return  # The file system has no locks.
    if not os.path.samestat(os.fstat(lock), os.stat(folder)):
        raise BadInput(folder, "", "another sweep writes to it")


def _append(path: Path, row: dict[str, Any]) -> None:
    line = json.dumps(row, allow_nan=False, ensure_ascii=False) + "\n"
    with open(path, "ab") as file:
        file.write(line.encode())
        file.flush()
        os.fsync(file.fileno())


def _drop_torn_line(path: Path) -> None:
    """Removes the last line if it is incomplete, because its process was killed.

    Raises:
        BadInput: if there is no such file.
    """
    try:
        with open(path, "rb+") as file:
            file.truncate(sum(len(line) for line in file if line.endswith(b"\n")))
    except (FileNotFoundError, IsADirectoryError) as error:
        raise BadInput(path, "", f"expected a file of the sweep: {error.strerror}") from None
