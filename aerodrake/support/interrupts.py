"""Deferred handling of Ctrl-C, SIGTERM and SIGHUP, so that results are saved first."""

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from typing import Any

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

MAX_INTERRUPTS = 3
"""Number of the interrupt that is not deferred."""

WARNING = b"\naerodrake: saving; another interrupt ends the command at once\n"


class _Deferral:
    """Handler of interrupts that counts them once it has begun; before, it raises them."""

    def __init__(self) -> None:
        self.has_begun = False
        self._received = 0

    def handle(self, number: int, frame: Any) -> None:
        if not self.has_begun:
            raise KeyboardInterrupt
        if number == signal.SIGHUP:
            self._received = max(self._received, 1)
            return
        self._received += 1
        if self._received == MAX_INTERRUPTS:
            raise KeyboardInterrupt
        if self._received == MAX_INTERRUPTS - 1:
            with suppress(OSError):  # Standard error may be closed or full.
                os.write(2, WARNING)  # `print` is not reentrant, and may be interrupted itself.

    def check(self) -> None:
        if self._received:
            raise KeyboardInterrupt


_lasting: _Deferral | None = None
"""The deferral of `lasting_deferral`, if one is active."""


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], None]]:
    """Defers interrupts, so that results are written.

    Yields:
        A function that raises KeyboardInterrupt if an interrupt was received. Code that
        never calls it runs to its end. The third interrupt is not deferred, except by a
        terminal that vanishes: the kernel and the shell send SIGHUP once each.
    """
    deferral = _lasting or _Deferral()
    deferral.has_begun = True
    with nullcontext() if _lasting else _handler(deferral.handle):
        yield deferral.check


@contextmanager
def lasting_deferral() -> Iterator[None]:
    """Makes a deferral that begins in its body last until its end.

    An interrupt that comes after a flight, before its results are written, is then deferred too.
    """
    global _lasting
    before, _lasting = _lasting, _Deferral()
    try:
        with _handler(_lasting.handle):
            yield
    finally:
        _lasting = before


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
