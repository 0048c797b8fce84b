"""Files: where they are, and reading and writing them safely."""

from __future__ import annotations

import io
import os
import stat
import zipfile
from importlib import resources
from pathlib import Path

from aerodrake.support.errors import BadInput
from aerodrake.support.scratch import scratch_folder

PACKAGE = "package://aerodrake/"


def is_packaged(file: str) -> bool:
    """Whether a `file` field names a file inside the package."""
    return file.startswith("package://")


def leaves_package(file: str) -> bool:
    """Whether a `package://` URI names another package, or a file outside of this one."""
    parts = file.removeprefix(PACKAGE).split("/")
    return not file.startswith(PACKAGE) or ".." in parts or "" in parts


def locate(file: str) -> Path:
    """The path that a `file` field stands for."""
    if is_packaged(file):
        return Path(str(resources.files("aerodrake"))) / file.removeprefix(PACKAGE)
    return Path(file)


def read_bounded(path: Path, most: int) -> bytes:
    """The content of a file that came from anywhere.

    Pipes and devices, which may never begin or never end, are not read.

    Raises:
        BadInput: if it cannot be read, or is longer than `most` bytes.
    """
    try:
        # A pipe without a writer is opened at once, to be refused.
        with open(path, "rb", opener=lambda p, flags: os.open(p, flags | os.O_NONBLOCK)) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                raise BadInput(path, "", "expected a file, got a pipe or a device")
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(path, "", f"expected a readable file: {reason}") from None
    if len(content) > most:
        raise BadInput(path, "", f"expected at most {most} bytes")
    return content


def is_stored_zip(content: bytes) -> bool:
    """Whether it is a zip that is no smaller than all that is in it."""
    try:
        entries = zipfile.ZipFile(io.BytesIO(content)).infolist()
    except Exception:  # What a malformed file raises is not documented.
        return False
    is_stored = all(entry.compress_type == zipfile.ZIP_STORED for entry in entries)
    # Entries that share their bytes would add up to more.
    return is_stored and sum(entry.file_size for entry in entries) <= len(content)


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a file: all of it, or nothing. A link goes on leading to the file.

    Raises:
        BadInput: if it cannot be written.
    """
    try:
        place = Path(os.path.realpath(path))
        mode = place.stat().st_mode & 0o777 if place.exists() else 0o666 & ~umask()
        with scratch_folder(place.parent) as scratch:
            (scratch / "new").write_bytes(content)
            (scratch / "new").chmod(mode)
            os.replace(scratch / "new", place)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(path, "", f"cannot be written: {reason}") from None


def umask() -> int:
    """The mode bits that new files are not to have."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
