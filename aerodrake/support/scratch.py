"""Hidden folders in which results are prepared, and what killed processes left of theirs."""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PREFIX = ".aerodrake-"
"""Of their names. One is locked for as long as its process lives."""

NEW, OLD = "new", "old"
"""In one: the folder that is to be in place, and the one that was, by the name they have there."""


@contextmanager
def scratch_folder(parent: Path) -> Iterator[Path]:
    """Yields an empty hidden folder in `parent`, which goes in the end with all that is in it.

    Those that killed processes left in `parent` go first. What is prepared in
    one is on the disk where it is to be, and so in place by a rename.

    Raises:
        OSError: if none can be made.
    """
    _clear(parent)
    folder, lock = _locked_folder(parent)
    try:
        yield folder
    finally:
        _end_replacement(folder)  # If an interrupt came in between.
        shutil.rmtree(folder, ignore_errors=True)
        os.close(lock)


def replace_folder(scratch: Path, place: Path) -> None:
    """Moves `scratch/new/NAME` to `place`, of that name. What was there goes.

    If that fails, what was there stays. If the process is killed between the
    two renames that this takes, whoever next makes a scratch folder here ends it.

    Raises:
        OSError: if it cannot be moved.
    """
    new, old = scratch / NEW / place.name, scratch / OLD / place.name
    if place.exists():
        old.parent.mkdir()
        os.replace(place, old)
    try:
        os.replace(new, place)
    except OSError:
        if old.exists():
            os.replace(old, place)
        raise


def _locked_folder(parent: Path) -> tuple[Path, int]:
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX, dir=parent))
        with contextlib.suppress(FileNotFoundError):
            lock = os.open(folder, os.O_RDONLY)
            with contextlib.suppress(OSError):  # Of a file system without locks.
                fcntl.flock(lock, fcntl.LOCK_EX)
            if folder.exists():  # Nobody took it for one that was left, before it was locked.
                return folder, lock
            os.close(lock)


def _clear(parent: Path) -> None:
    """Removes the scratch folders of dead processes; of a replacement, only once it is ended."""
    for folder in parent.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # It lives, or is another user's.
            lock = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                _end_replacement(folder)
                shutil.rmtree(folder, ignore_errors=True)
            finally:
                os.close(lock)


def _end_replacement(scratch: Path) -> None:
    """The rename that is missing where a folder was moved away and none is in its place."""
    for old in (scratch / OLD).glob("*"):
        place, new = scratch.parent / old.name, scratch / NEW / old.name
        if not place.exists():
            os.replace(new if new.exists() else old, place)
