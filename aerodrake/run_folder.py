"""The folder of a run: complete, or not there."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from aerodrake.errors import BadInput
from aerodrake.files import umask

MARKERS = ("summary.json", "log.npz", "scenario.yaml")
"""What tells an earlier run, which may be replaced, from a person's own folder."""


@contextmanager
def run_folder(target: Path, markers: Sequence[str] = MARKERS) -> Iterator[Path]:
    """Yields a temporary folder that becomes `target` if all goes well.

    An earlier run in `target` is replaced as a whole; a link to it stays.

    Args:
        target: Where the results are to be.
        markers: The files that every folder of the command's results has.

    Raises:
        BadInput: if `target` cannot be written, or holds files of another kind.
    """
    target = Path(target)
    with _writing(target):
        if "\0" in str(target):
            raise OSError("expected a path without a NUL")
        place = target.resolve()
        if place.exists() and not place.is_dir():
            raise BadInput("--out", "", f"expected a folder, but {target} is a file")
        if place.is_dir() and any(place.iterdir()) and not _is_earlier(place, markers):
            raise BadInput("--out", "", f"{target} holds files that are not of an earlier run")
        if place.is_dir() and (
            os.path.ismount(place) or place in (Path.cwd(), *Path.cwd().parents)
        ):
            raise BadInput(
                "--out", "", f"{target} is in use and cannot be replaced; expected a folder in it"
            )
        place.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{place.name}-"[:100], dir=place.parent))
    try:
        with _writing(target):
            yield scratch
            scratch.chmod(0o777 & ~umask())
            _replace(place, scratch)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _is_earlier(folder: Path, markers: Sequence[str]) -> bool:
    return all((folder / name).is_file() for name in markers)


def _replace(place: Path, scratch: Path) -> None:
    """Moves `scratch` to `place`; what was there goes, or stays if that fails."""
    old = scratch.with_name(f"{scratch.name}.old")
    if place.exists():
        os.replace(place, old)
    try:
        os.replace(scratch, place)
    except OSError:
        if old.exists():
            os.replace(old, place)
        raise
    shutil.rmtree(old, ignore_errors=True)


@contextmanager
def _writing(target: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise BadInput("--out", "", f"cannot write {target}: {error.strerror or error}") from None
