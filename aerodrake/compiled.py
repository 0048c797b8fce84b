"""Equations that run at every sample, compiled to machine code."""

from __future__ import annotations

import hashlib
import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

EQUATIONS = Path(__file__).parent / "model"


def cache_folder(sources: Path, elsewhere: Path) -> Path:
    """Where machine code of a folder of sources is kept, by what all of them say.

    numba itself looks at the file of a function alone: not at functions of other files that
    it has inlined, nor at numbers that it took from there. Machine code of other contents in
    the same place is deleted.

    Args:
        sources: Beside these, in `__pycache__`, where that can be written.
        elsewhere: Else here.
    """
    content = hashlib.sha256()
    for source in sorted(sources.glob("*.py")):
        content.update(source.name.encode() + source.read_bytes())
    beside = sources / "__pycache__"
    place = beside if os.access(beside if beside.exists() else sources, os.W_OK) else elsewhere
    folder = place / f"compiled-{content.hexdigest()[:16]}"
    for other in place.glob("compiled-*"):
        if other != folder:
            shutil.rmtree(other, ignore_errors=True)
    return folder


def _cache_home() -> Path:
    home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(home, "aerodrake")


CACHE = cache_folder(EQUATIONS, Path(os.environ.get("NUMBA_CACHE_DIR") or _cache_home()))


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
