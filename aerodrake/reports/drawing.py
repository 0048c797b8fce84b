"""Drawings beside the results of a command, which are kept if a drawing fails."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

_log = logging.getLogger(__name__)


@contextmanager
def drawing(path: Path) -> Iterator[None]:
    """Reports in one line if the drawing of a file fails; the file is then left out.

    The results are already saved when they are drawn, so that an error of a drawing library, or a
    full disk, ends the drawing alone. Interrupts are raised.

    Args:
        path: The file that is drawn in the body, which writes it atomically.
    """
    try:
        yield
    except (Exception, SystemExit) as error:  # Drake raises SystemExit if a check fails.
        reason = " ".join(str(error).split()) or "no reason given"
        _log.warning("%s is not drawn: %s: %.300s", path, type(error).__name__, reason)
