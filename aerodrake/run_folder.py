"""The folder of a run: complete, or not there."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aerodrake.errors import BadInput

MARKER = "summary.json"
"""What tells an earlier run, which may be replaced, from a person's own folder."""


@contextmanager
def run_folder(target: Path) -> Iterator[Path]:
    """Yields a temporary folder that becomes `target` if all goes well.

    An earlier run in `target` is replaced as a whole.

    Raises:
        BadInput: if `target` cannot be written, or holds files of another kind.
    """
    target = Path(target)
    try:
        if target.exists() and not target.is_dir():
            raise BadInput("--out", "", f"expected a folder, but {target} is a file")
        if target.is_dir() and any(target.iterdir()) and not (target / MARKER).is_file():
            raise BadInput("--out", "", f"{target} holds files that are not of an earlier run")
        target.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix=f".{target.name}-", dir=target.parent))
    except OSError as error:
        raise BadInput("--out", "", f"cannot write {target}: {error.strerror}") from None
    try:
        yield scratch
        scratch.chmod(0o777 & ~_umask())
        if target.exists():
            old = scratch.with_name(f"{scratch.name}.old")
            os.replace(target, old)
            os.replace(scratch, target)
            shutil.rmtree(old)
        else:
            os.replace(scratch, target)
    except OSError as error:
        raise BadInput("--out", "", f"cannot write {target}: {error.strerror}") from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
