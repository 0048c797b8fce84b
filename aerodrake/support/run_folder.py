"""Folder of a command's results, which is written atomically."""

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from aerodrake.support.errors import BadInput, writing
from aerodrake.support.scratch import NEW, replace_folder, scratch_folder

MARKERS = ("summary.json", "log.npz", "scenario.yaml")
"""Files by which an earlier run, which may be replaced, differs from another folder."""


@contextmanager
def run_folder(target: Path, markers: Sequence[str] = MARKERS) -> Iterator[Path]:
    """Yields a hidden folder that is moved to `target` if no error occurs.

    It replaces an earlier run in `target` as a whole; of a link, the link's target.

    Args:
        target: Path of the results.
        markers: Files that every folder of the command's results has; patterns as for `Path.glob`.

    Raises:
        BadInput: if `target` cannot be written, or has other files than an earlier run.
    """
    path = check_target(target, markers)
    with writing(target):
        path.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(path.parent) as scratch:
            new = scratch / NEW / path.name
            new.mkdir(parents=True)
            yield new
            replace_folder(scratch, path)


def existing_folder(target: str | os.PathLike[str]) -> Path:
    """Returns the path of a folder, which is created if it is missing.

    Raises:
        BadInput: if it cannot be created.
    """
    path = Path(target)
    with writing(path):
        path.mkdir(parents=True, exist_ok=True)
    return path


def check_target(target: Path, markers: Sequence[str] = MARKERS) -> Path:
    """Checks that `run_folder` can write `target`, and returns its path without links.

    Raises:
        BadInput: as for `run_folder`.
    """
    with writing(target):
        path = Path(os.path.realpath(target))
        if path.is_symlink():
            raise BadInput(target, "", "expected a folder, got a link to itself")
        if path.exists() and not path.is_dir():
            raise BadInput(target, "", "expected a folder, got a file")
        # Creating a folder shows that it is possible, and completes interrupted replacements.
        with scratch_folder(next(parent for parent in path.parents if parent.exists())):
            is_run = all(any(map(Path.is_file, path.glob(name))) for name in markers)
            if path.is_dir() and any(path.iterdir()) and not is_run:
                raise BadInput(target, "", "holds files that are not of an earlier run")
        if path.is_dir() and (os.path.ismount(path) or path in (Path.cwd(), *Path.cwd().parents)):
            message = "expected a folder that can be replaced, got a mount point or a folder that "
            raise BadInput(target, "", message + "contains the working directory")
    return path
