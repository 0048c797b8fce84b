"""Hidden folders in which results are prepared, and cleanup after killed processes."""

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aerodrake.support.errors import writing

PREFIX = ".aerodrake-"
"""Prefix of the folders' names. A folder is locked while its process is running."""

NEW, OLD = "new", "old"
"""Names, in a scratch folder, of the parents of the new folder and of the replaced one."""


@contextmanager
def scratch_folder(parent: Path) -> Iterator[Path]:
    """Yields an empty hidden folder in `parent`, which is removed at the end.

    Removes the scratch folders of killed processes first. The folder is on the same file system
    as `parent`, so that results can be renamed into place.

    Raises:
        OSError: if the folder cannot be created.
    """
    _clear(parent)
    folder, lock = _locked_folder(parent)
    try:
        yield folder
    finally:
        _complete_replacement(folder)  # After an interrupt between the two renames.
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yields an empty folder for temporary files, which is removed at the end.

    Raises:
        BadInput: if it cannot be created.
    """
    parent = Path(tempfile.gettempdir())
    with contextlib.ExitStack() as stack:
        with writing(parent):
            folder = stack.enter_context(scratch_folder(parent))
        yield folder


def replace_folder(scratch: Path, path: Path) -> None:
    """Moves `scratch/new/NAME` to `path`, whose name is NAME, and replaces the folder there.

    If the move fails, the earlier folder is restored. If the process is killed between the two
    renames, the next scratch folder in the same parent completes the replacement.

    Raises:
        OSError: if the folder cannot be moved.
    """
    new, old = scratch / NEW / path.name, scratch / OLD / path.name
    if path.exists():
        old.parent.mkdir()
        os.replace(path, old)
    try:
        os.replace(new, path)
    except OSError:
        if old.exists():
            os.replace(old, path)
        raise


def _locked_folder(parent: Path) -> tuple[Path, int]:
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))
        with contextlib.suppress(FileNotFoundError):
            lock = os.open(folder, os.O_RDONLY)
            with contextlib.suppress(OSError):  # The file system has no locks.
                fcntl.flock(lock, fcntl.LOCK_EX)
            if folder.exists():  # No other process removed it before it was locked.
                return folder, lock
            os.close(lock)


def _clear(parent: Path) -> None:
    """Completes the replacements of dead processes and removes their scratch folders."""
    for folder in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # Its process is running, or of another user.
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                _complete_replacement(folder)
                shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(lock)


def _complete_replacement(scratch: Path) -> None:
    """Does the second rename if a folder was moved away and nothing is at its path."""
    for old in (scratch / OLD).glob("*"):
        path, new = scratch.parent / old.name, scratch / NEW / old.name
        if not path.exists():
            os.replace(new if new.exists() else old, path)
