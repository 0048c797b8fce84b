"""The folder of a run: complete, or not there."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from aerodrake.support.errors import BadInput
from aerodrake.support.scratch import NEW, replace_folder, scratch_folder

MARKERS = ("summary.json", "log.npz", "scenario.yaml")
"""What tells an earlier run, which may be replaced, from a person's own folder."""


@contextmanager
def run_folder(target: Path, markers: Sequence[str] = MARKERS) -> Iterator[Path]:
    """Yields a hidden folder that becomes `target` if all goes well.

    An earlier run in `target` is replaced as a whole; a link to it stays.

    Args:
        target: Where the results are to be.
        markers: The files that every folder of the command's results has.

    Raises:
        BadInput: if `target` cannot be written, or holds files of another kind.
    """
    with _writing(target):
        if "\0" in str(target):
            raise OSError("expected a path without a NUL")
        place = Path(os.path.realpath(target))
        if place.is_symlink():
            raise BadInput("--out", "", f"{target} is a link that leads back to itself")
        if place.exists() and not place.is_dir():
            raise BadInput("--out", "", f"expected a folder, but {target} is a file")
        place.parent.mkdir(parents=True, exist_ok=True)
        with scratch_folder(place.parent) as scratch:
            _check_replaceable(place, target, markers)
            new = scratch / NEW / place.name
            new.mkdir(parents=True)
            yield new
            replace_folder(scratch, place)


def _check_replaceable(place: Path, target: Path, markers: Sequence[str]) -> None:
    if not place.is_dir():
        return
    is_earlier = all((place / name).is_file() for name in markers)
    if any(place.iterdir()) and not is_earlier:
        raise BadInput("--out", "", f"{target} holds files that are not of an earlier run")
    if os.path.ismount(place) or place in (Path.cwd(), *Path.cwd().parents):
        raise BadInput(
            "--out", "", f"{target} is in use and cannot be replaced; expected a folder in it"
        )


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise BadInput("--out", "", f"cannot write {target}: {error.strerror or error}") from None
