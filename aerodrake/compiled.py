"""Equations that run at every sample, compiled to machine code."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from numba import njit

compiled = njit(cache=True, error_model="numpy")
"""Compiles a function of arrays, numbers and named tuples of them; calls of others inline.

What a function of small vectors costs in numpy is the calls, not the arithmetic: compiled
it takes a tenth or less. The first run on a machine compiles, later ones read its cache.
Arithmetic is IEEE's, in the order as written, so that results repeat bit for bit; division
by zero gives inf or nan as in numpy. With NUMBA_DISABLE_JIT=1 in the environment the same
lines run as plain Python.
"""


def forget_stale(folder: Path) -> None:
    """Deletes cached machine code that is older than the newest source of any beside it.

    numba itself looks at the file of a function alone, not at those that it has inlined.

    Args:
        folder: Of sources; numba's indices are in its `__pycache__`, named `source.function-...`.
    """
    indices = list((folder / "__pycache__").glob("*.nbi"))
    sources = {folder / f"{index.name.split('.')[0]}.py" for index in indices}
    newest = max((s.stat().st_mtime for s in sources if s.exists()), default=0.0)
    for index in indices:
        with suppress(FileNotFoundError):  # Another process may be at it, too.
            if index.stat().st_mtime < newest:
                index.unlink()


def is_cold(folder: Path) -> bool:
    """Whether nothing in a folder that machine code is kept in has been compiled yet."""
    return os.access(folder, os.W_OK) and not any((folder / "__pycache__").glob("*.nbi"))


EQUATIONS = Path(__file__).parent / "model"

forget_stale(EQUATIONS)
