"""Compilation of equations to machine code, with a cache on disk."""

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import config, njit

from aerodrake.support.cache_folders import (
    first_writable,
    let_matplotlib_cache,
    private_folder,
    user_folder,
)
from aerodrake.support.machine_code import SUFFIX, MachineCode

EQUATIONS = Path(__file__).parents[1] / "model"


class CacheFolders:
    """Folders of the machine code of some sources, named by a hash of all their files.

    The hash covers the functions and constants that a function inlines from other files. New code
    is written to `NUMBA_CACHE_DIR` if that is set, else to the `__pycache__` of the sources, else
    to the user's cache; if all of them are not writable, to a temporary folder. Code is read from
    any of them, so that a cache that was installed with the package is used by all users.

    Attributes:
        reads: Folders in which code may be.
        writes: Folder of new code; None if no folder can be written.
        note: One line if the usual folders cannot be written; empty otherwise.

    Args:
        sources: Folder of the sources.
    """

    def __init__(self, sources: Path):
        content = hashlib.sha256()
        for source in sorted(sources.rglob("*.py")):
            content.update(str(source.relative_to(sources)).encode() + source.read_bytes())
        name = f"compiled-{content.hexdigest()[:16]}"
        beside, user = sources / "__pycache__", user_folder("XDG_CACHE_HOME", "~/.cache")
        usual = [beside, *([user / "aerodrake"] if user else [])]
        if config.CACHE_DIR:
            usual = [Path(config.CACHE_DIR).absolute()]
        writes = first_writable(usual)
        self.note = ""
        if writes is None:
            writes = private_folder()
            kept = f"kept in {writes}" if writes else "compiled anew in each process"
            folders = " and ".join(map(str, usual))
            self.note = f"compiled code is {kept}, since {folders} cannot be written"
        self._new = [self.note] if self.note else []
        self.reads = [
            folder / name for folder in dict.fromkeys([*usual, *([writes] if writes else [])])
        ]
        self.writes = writes and writes / name
        if writes == beside:  # Other installations do not use this folder.
            for other in beside.glob("compiled-*"):
                if other.name != name:
                    shutil.rmtree(other, ignore_errors=True)

    def new_notes(self) -> list[str]:
        """Returns the note at the first call, if there is one; then none."""
        notes, self._new = self._new, []
        return notes


CACHE = CacheFolders(EQUATIONS)
let_matplotlib_cache()  # Before its first import, which chooses its folder.


def is_cold() -> bool:
    """Returns True if the equations are not compiled yet, which takes a minute."""
    return not any(any(folder.glob(f"*{SUFFIX}")) for folder in CACHE.reads)


def compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compiles a function of arrays, numbers and NamedTuples, with numba.

    The cost of small vectors in numpy is the calls, not the arithmetic: compiled code takes a
    tenth of the time or less. The first run on a machine compiles, later runs read the cache.
    Arithmetic is IEEE 754 in the written order, and BLAS for matrix products, so that results
    on one machine are reproducible bit for bit. Division by zero gives inf or nan as in numpy.
    With NUMBA_DISABLE_JIT=1 in the environment the function runs as Python; results then agree
    up to rounding.
    """
    dispatcher = njit(error_model="numpy")(function)
    if not config.DISABLE_JIT:
        dispatcher._cache = MachineCode(function, CACHE.reads, CACHE.writes)
    return dispatcher
