"""Where files are: beside the scenario, or inside the package."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

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
