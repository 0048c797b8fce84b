"""Compilation of equations to machine code, with a cache on disk."""

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

EQUATIONS = Path(__file__).parents[1] / "model"


def cache_folder(sources: Path, elsewhere: Path) -> Path:
    """Returns the cache folder for machine code, named by a hash of all source files.

    numba's own cache only checks the file of a function, not the files of the functions and
    constants that it inlines. Caches of other hashes in `__pycache__` are deleted.

    Args:
        sources: Folder of the sources. The cache is in its `__pycache__` if that is writable.
        elsewhere: Parent of the cache otherwise.
    """
    content = hashlib.sha256()
    for source in sorted(sources.rglob("*.py")):
        content.update(str(source.relative_to(sources)).encode() + source.read_bytes())
    beside = sources / "__pycache__"
    name = f"compiled-{content.hexdigest()[:16]}"
    if not os.access(beside if beside.exists() else sources, os.W_OK):
        return elsewhere / name
    for other in beside.glob("compiled-*"):
        if other.name != name:
            shutil.rmtree(other, ignore_errors=True)
    return beside / name


CACHE = cache_folder(
    EQUATIONS, Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser(), "aerodrake")
)


def is_cold() -> bool:
    """Returns True if the equations are not compiled yet, which takes a minute."""
    return not any(CACHE.rglob("*.nbi"))


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compiles a function of arrays, numbers and NamedTuples, with numba.

    The cost of small vectors in numpy is the calls, not the arithmetic: compiled code takes a
    tenth of the time or less. The first run on a machine compiles, later runs read the cache.
    Arithmetic is IEEE 754 in the written order, and BLAS for matrix products, so that results
    on one machine are reproducible bit for bit. Division by zero gives inf or nan as in numpy.
    With NUMBA_DISABLE_JIT=1 in the environment the function runs as Python; results then agree
    up to rounding.
    """
    before, config.CACHE_DIR = config.CACHE_DIR, str(CACHE)
    try:
        return njit(cache=True, error_model="numpy")(function)
    finally:
        config.CACHE_DIR = before
