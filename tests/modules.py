"""The package's modules, for tests that read them."""

from pathlib import Path

import pytest

import aerodrake

PACKAGE = Path(aerodrake.__file__).parent

MODULES = sorted(PACKAGE.rglob("*.py"))


def relative(path: Path) -> str:
    return str(path.relative_to(PACKAGE))


def dotted(path: Path) -> str:
    parts = ["aerodrake", *path.relative_to(PACKAGE).with_suffix("").parts]
    return ".".join(part for part in parts if part != "__init__")


everywhere = pytest.mark.parametrize("path", MODULES, ids=relative)
