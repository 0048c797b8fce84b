"""Standard streams that may be closed, full, or without a reader."""

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

BROKEN_PIPE_CODE = 141
"""Exit code that a shell reports for a program that SIGPIPE ends (128 + 13)."""

UNWRITABLE_CODE = 1
"""Exit code if standard output cannot be written for another reason."""


class OutputStream:
    """Text stream that never raises: after the first error it drops everything.

    Other attributes, such as `encoding`, `isatty` and `fileno`, are the stream's.

    Attributes:
        error: The first error of writing; None without one.

    Args:
        stream: Any text stream; None for one that was closed when the process started.
    """

    def __init__(self, stream: TextIO | None):
        self.error: OSError | ValueError | None = None
        self._was_closed = stream is None
        self._stream = open(os.devnull, "w") if stream is None else stream  # noqa: SIM115

    def write(self, text: str) -> int:
        """Writes text. Characters that the encoding lacks become backslash escapes."""
        if self._was_closed:
            self.error = OSError(errno.EBADF, os.strerror(errno.EBADF))
        elif self.error is None:
            encoding = getattr(self._stream, "encoding", None) or "utf-8"
            text = text.encode(encoding, "backslashreplace").decode(encoding)
            try:
                self._stream.write(text)
            except (OSError, ValueError) as error:  # ValueError: closed by the program itself.
                self.error = error
        return len(text)

    def flush(self) -> None:
        """Writes buffered text."""
        if self.error is None:
            try:
                self._stream.flush()
            except (OSError, ValueError) as error:
                self.error = error

    def exit_code(self, code: int) -> int:
        """Returns the exit code of a command that wrote its results to this stream.

        If something could not be written, prints one line to `sys.stderr` and replaces code 0.

        Args:
            code: The command's own exit code.
        """
        self.flush()
        if self.error is None:
            return code
        reason = getattr(self.error, "strerror", None) or self.error
        print(f"aerodrake: cannot write to standard output: {reason}", file=sys.stderr)
        is_broken = isinstance(self.error, BrokenPipeError)
        return code or (BROKEN_PIPE_CODE if is_broken else UNWRITABLE_CODE)

    def close_broken(self) -> None:
        """Connects the stream to the null device if it is broken.

        Python flushes its buffer again at exit, and would fail with code 120.
        """
        if self.error is not None:
            with suppress(OSError, ValueError):
                null = os.open(os.devnull, os.O_WRONLY)
                os.dup2(null, self._stream.fileno())
                os.close(null)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def output_streams() -> Iterator[OutputStream]:
    """Replaces `sys.stdout` and `sys.stderr` by streams that never raise; yields the first.

    All output of a command goes through them, also that of progress bars and of argparse, so
    that a broken stream neither ends a flight nor is mistaken for an error of its results.
    """
    _open_closed_descriptors()
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = output, errors = OutputStream(sys.stdout), OutputStream(sys.stderr)
    try:
        yield output
    finally:
        sys.stdout, sys.stderr = before
        for stream in (output, errors):
            stream.flush()
            stream.close_broken()


def _open_closed_descriptors() -> None:
    """Opens the null device at descriptors 0, 1 and 2 that are closed.

    The next file that the process opens would otherwise be its standard error, and would receive
    what libraries print.
    """
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # The lowest number is free.
        else:
            with suppress(OSError):
                os.set_blocking(descriptor, True)  # Else a slow reader is an error.
