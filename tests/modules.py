"""The package's modules, for tests that read them."""

import inspect
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

import pytest
from pydrake.systems.framework import LeafSystem

import aerodrake

PACKAGE = Path(aerodrake.__file__).parent

MODULES = sorted(PACKAGE.rglob("*.py"))


def relative(path: Path) -> str:
    return str(path.relative_to(PACKAGE))


def dotted(path: Path) -> str:
    parts = ["aerodrake", *path.relative_to(PACKAGE).with_suffix("").parts]
    return ".".join(part for part in parts if part != "__init__")


everywhere = pytest.mark.parametrize("path", MODULES, ids=relative)


def _leaf_systems() -> Iterator[type[LeafSystem]]:
    for path in MODULES:
        if path.relative_to(PACKAGE).parts[0] in ("systems", "wire"):
            for _, kind in inspect.getmembers(import_module(dotted(path)), inspect.isclass):
                if issubclass(kind, LeafSystem) and kind.__module__ == dotted(path):
                    yield kind


SYSTEMS = list(_leaf_systems())
"""Every LeafSystem of the package."""
