"""Machine code of compiled functions on disk."""

import hashlib
import pickle
import sys
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core.caching import FunctionCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from aerodrake.support.errors import BadInput
from aerodrake.support.files import write_atomically

SUFFIX = ".nbc"
"""Suffix of the files."""

VERSIONS = numba.__version__, llvmlite.__version__, sys.implementation.cache_tag
"""Versions on which the content of the files depends, besides the processor."""

_DIGEST_BYTES = hashlib.sha256().digest_size


class MachineCode(FunctionCache):
    """Cache of one function, with a file for each signature, processor and version of numba.

    Each file has a checksum: a file that is damaged, truncated or unreadable is replaced, as is
    one that is missing. numba's own files raise errors until they are deleted by hand, and two
    processes that compile one function at a time can exchange the code of two signatures.

    Args:
        function: The function that is compiled.
        reads: Folders in which machine code may be, in the order of the search.
        writes: Folder of new files; None to keep none.
    """

    def __init__(self, function: Callable[..., Any], reads: Sequence[Path], writes: Path | None):
        self._py_func = function  # Of the base class, which computes the key from it.
        self._name = repr(function)
        self._reads = reads
        self._writes = writes
        self.enable()

    @property
    def cache_path(self) -> str:
        """Folder of new files, or empty."""
        return str(self._writes or "")

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """Returns the compiled function of a signature; None if there is no valid file."""
        target_context.refresh()
        name = self._file_name(sig, target_context.codegen())
        for folder in self._reads if self._enabled else ():
            with suppress(OSError):
                content = (folder / name).read_bytes()
                digest, code = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
                if digest == _digest(name, code):
                    return CompileResult._rebuild(target_context, *pickle.loads(code))
        return None

    def save_overload(self, sig: Any, data: CompileResult) -> None:
        """Writes the compiled function of a signature, unless the disk is full."""
        if self._enabled and self._writes:
            name = self._file_name(sig, data.codegen)
            code = dumps(data._reduce())
            with suppress(OSError, BadInput):
                self._writes.mkdir(parents=True, exist_ok=True)
                write_atomically(self._writes / name, _digest(name, code) + code)

    def flush(self) -> None:
        """Deletes the files of the function."""
        for path in self._writes.glob(f"{self._label}-*{SUFFIX}") if self._writes else ():
            path.unlink(missing_ok=True)

    @property
    def _label(self) -> str:
        function = self._py_func
        name = f"{function.__module__}.{function.__qualname__}".replace("<", "").replace(">", "")
        return f"{name}-{function.__code__.co_firstlineno}"

    def _file_name(self, sig: Any, codegen: Any) -> str:
        key = repr((VERSIONS, self._index_key(sig, codegen)))
        return f"{self._label}-{hashlib.sha256(key.encode()).hexdigest()[:20]}{SUFFIX}"


def _digest(name: str, code: bytes) -> bytes:
    return hashlib.sha256(name.encode() + code).digest()
