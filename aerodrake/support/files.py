"""Paths of packaged files, bounded reading and atomic writing."""

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
    """Returns True if a `file` field is a `package://` URI."""
    return file.startswith("package://")


def leaves_package(file: str) -> bool:
    """Returns True if a `package://` URI is of another package, or leaves this one."""
    parts = file.removeprefix(PACKAGE).split("/")
    return not file.startswith(PACKAGE) or ".." in parts or "" in parts


def locate(file: str) -> Path:
    """Returns the path of a `file` field."""
    if is_packaged(file):
        return Path(str(resources.files("aerodrake"))) / file.removeprefix(PACKAGE)
    return Path(file)


def read_bounded(path: Path, most: int) -> bytes:
    """Returns the content of an untrusted file.

    Pipes and devices, which can block or be endless, are refused.

    Raises:
        BadInput: if the file cannot be read, or has more than `most` bytes.
    """
    try:
        # Without O_NONBLOCK opening a pipe blocks until it has a writer.
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


def check_stored_zip(content: bytes) -> None:
    """Checks that the content is a zip archive without compression and damage.

    Raises:
        ValueError: if it is not, or if its entries are larger than itself; the message is what it
            is instead.
    """
    if not content:
        raise ValueError("an empty file")
    try:
        archive = zipfile.ZipFile(io.BytesIO(content))
        entries = archive.infolist()
    except Exception:  # The exceptions for malformed files are not documented.
        raise ValueError("another or a truncated file") from None
    is_stored = all(entry.compress_type == zipfile.ZIP_STORED for entry in entries)
    # Overlapping entries would have a larger sum.
    if not is_stored or sum(entry.file_size for entry in entries) > len(content):
        raise ValueError("a compressed file")
    try:
        damaged = archive.testzip()  # Compares checksums.
    except Exception:
        damaged = "its headers"
    if damaged is not None:
        raise ValueError("a damaged file")


def write_atomically(path: Path, content: bytes) -> None:
    """Writes a file atomically. Permissions are preserved; of a link, its target is written.

    Raises:
        BadInput: if the file cannot be written.
    """
    try:
        target = Path(os.path.realpath(path))
        mode = target.stat().st_mode & 0o777 if target.exists() else 0o666 & ~umask()
        with scratch_folder(target.parent) as scratch:
            (scratch / "new").write_bytes(content)
            (scratch / "new").chmod(mode)
            os.replace(scratch / "new", target)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise BadInput(path, "", f"cannot be written: {reason}") from None


def umask() -> int:
    """Returns the process's umask."""
    mask = os.umask(0)
    os.umask(mask)
    return mask
