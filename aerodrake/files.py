"""Files: where they are, and reading and writing them safely."""

from __future__ import annotations

import contextlib
import io
import os
import tempfile
import zipfile
from importlib import resources
from pathlib import Path

from aerodrake.errors import BadInput

PACKAGE = "package://aerodrake/"


def is_packaged(file: str) -> bool:
    """Whether a `file` field names a file inside the package."""
    return file.startswith("package://")


def leaves_package(file: str) -> bool:
    """Whether a `package://` URI names another package, or a file outside of this one."""
    return not file.startswith(PACKAGE) or ".." in file.split("/")


def locate(file: str) -> Path:
    """The path that a `file` field stands for."""
    if is_packaged(file):
        return Path(str(resources.files("aerodrake"))) / file.removeprefix(PACKAGE)
    return Path(file)


def read_bounded(path: Path, most: int) -> bytes:
    """The content of a file that came from anywhere.

    Raises:
        BadInput: if it cannot be read, or is longer than `most` bytes.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise BadInput(path, "", f"expected a readable file: {error.strerror}") from None
    if len(content) > most:
        raise BadInput(path, "", f"expected at most {most} bytes")
    return content


def is_stored_zip(content: bytes) -> bool:
    """Whether it is a zip without compression, so that what is small stays small when read."""
    try:
        entries = zipfile.ZipFile(io.BytesIO(content)).infolist()
    except Exception:  # What a malformed file raises is not documented.
        return False
    return all(entry.compress_type == zipfile.ZIP_STORED for entry in entries)


def write_whole(path: Path, content: bytes) -> None:
    """Writes a file: all of it, or nothing. A link goes on leading to the file.

    Raises:
        BadInput: if it cannot be written.
    """
    place = Path(path).resolve()
    scratch = None
    try:
        mode = place.stat().st_mode & 0o777 if place.exists() else 0o666 & ~umask()
        with tempfile.NamedTemporaryFile(dir=place.parent, prefix=".", delete=False) as file:
            scratch = Path(file.name)
            file.write(content)
        scratch.chmod(mode)
        os.replace(scratch, place)
    except OSError as error:
        raise BadInput(path, "", f"cannot be written: {error.strerror}") from None
    finally:
        if scratch is not None:
            with contextlib.suppress(OSError):
                scratch.unlink()


def umask() -> int:
    """The mode bits that new files are not to have."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
