"""Deferred handling of Ctrl-C, SIGTERM and SIGHUP, so that results are saved first."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

MAX_INTERRUPTS = 3
"""Number of the interrupt that is not deferred."""

WARNING = b"\naerodrake: saving; another interrupt ends the command at once\n"


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Defers interrupts, so that results are written.

    Yields:
        A function that raises KeyboardInterrupt if an interrupt was received. Code that
        never calls it runs to its end. The third interrupt is not deferred, except by a
        terminal that vanishes: the kernel and the shell send SIGHUP once each.
    """
    received = 0

    def defer(number: int, frame: Any) -> None:
        nonlocal received
        if number == signal.SIGHUP:
            received = max(received, 1)
            return
        received += 1
        if received == MAX_INTERRUPTS:
            raise KeyboardInterrupt
        if received == MAX_INTERRUPTS - 1:
            with suppress(OSError):  # Standard error may be closed or full.
                os.write(2, WARNING)  # `print` is not reentrant, and may be interrupted itself.

    def check() -> None:
        if received:
            raise KeyboardInterrupt

    with _handler(defer):
        yield check


@contextmanager
def termination_as_interrupt() -> Iterator[None]:
    """Makes SIGTERM and SIGHUP raise KeyboardInterrupt, so that unfinished files are removed."""
    with _handler(signal.default_int_handler):
        yield


@contextmanager
def _handler(handler: Callable[[int, Any], None]) -> Iterator[None]:
    """Sets the handler of `SIGNALS`, except for ignored ones (in a background job).

    Without effect outside of the main thread.
    """
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
