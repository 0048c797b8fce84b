"""Equations that run at every sample, compiled to machine code."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

EQUATIONS = Path(__file__).parents[1] / "model"


def cache_folder(sources: Path, elsewhere: Path) -> Path:
    """Where machine code of a folder of sources is kept, by what all of them say.

    numba itself looks at the file of a function alone: not at functions of other files that
    it has inlined, nor at numbers that it took from there. Machine code beside the sources
    that is of other contents is deleted.

    Args:
        sources: Beside these, in `__pycache__`, where that can be written.
        elsewhere: Else here.
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
    EQUATIONS,
    Path(os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser(), "aerodrake"),
)


def is_cold() -> bool:
    """Whether the equations are yet to be compiled, which takes a minute."""
    return not any(CACHE.rglob("*.nbi"))


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compiles a function of arrays, numbers and named tuples of them; calls of others inline.

    What a function of small vectors costs in numpy is the calls, not the arithmetic: compiled
    it takes a tenth or less. The first run on a machine compiles, later ones read its cache.
    Arithmetic is IEEE's, in the order as written, and that of BLAS in matrix products: on one
    machine results repeat bit for bit. Division by zero gives inf or nan as in numpy. With
    NUMBA_DISABLE_JIT=1 in the environment the same lines run as Python, to rounding.
    """
    before, config.CACHE_DIR = config.CACHE_DIR, str(CACHE)
    try:
        return njit(cache=True, error_model="numpy")(function)
    finally:
        config.CACHE_DIR = before
