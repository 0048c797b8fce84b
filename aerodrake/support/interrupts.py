"""Ctrl-C and SIGTERM: held back while there is something to lose."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM)

PATIENCE = 3
"""The interrupt that is not held back."""

WARNING = b"\naerodrake: saving; interrupt again to lose it\n"


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Holds interrupts back, so that what was flown is written down.

    Yields:
        A function that raises KeyboardInterrupt if one came, to be called where
        that is expected. Whoever never calls it goes on to the end. The third
        interrupt raises at once, wherever it comes.
    """
    came = 0

    def hold(number: int, frame: Any) -> None:
        nonlocal came
        came += 1
        if came == PATIENCE:
            raise KeyboardInterrupt
        if came == PATIENCE - 1:
            os.write(2, WARNING)  # Not by `print`, which may have been what was interrupted.

    def check() -> None:
        if came:
            raise KeyboardInterrupt

    with _handler(hold):
        yield check


@contextmanager
def termination_as_interrupt() -> Iterator[None]:
    """SIGTERM does as Ctrl-C does: what is half done is cleared away."""
    with _handler(signal.default_int_handler):
        yield


@contextmanager
def _handler(handler: Callable[[int, Any], None]) -> Iterator[None]:
    """Sets it, but where a signal is ignored, as in the background, or in another thread."""
    before = {}
    if threading.current_thread() is threading.main_thread():
        before = {number: signal.getsignal(number) for number in SIGNALS}
    try:
        for number, previous in before.items():
            if previous is not signal.SIG_IGN:
                signal.signal(number, handler)
        yield
    finally:
        for number, previous in before.items():
            signal.signal(number, previous)
