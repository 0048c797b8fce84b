"""Calls in a process apart, which is there for the next one, but not for ever."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection, Pipe
from typing import Any, TypeVar

from aerodrake.support.errors import ProcessDied
from aerodrake.support.processes import cause_of_death

Result = TypeVar("Result")

MOST_CALLS = 40
"""Of one child. Drake's diagrams are never collected, at 7 MB each, and a new child takes 4 s."""

IDLE_S = 60.0
"""A child that was not called for so long ends: whose caller lives on, in a cluster say."""

BEGUN = None
"""What a child says once it has imported what it is to call."""

_own = threading.local()
_children: set[_Child] = set()


class NeverBegan(ProcessDied):
    """A child died before it came to what it was called for."""


def apart(function: Callable[..., Result], *arguments: Any) -> Result:
    """Calls a function in a child process, of which each thread that calls has one.

    A child takes `MOST_CALLS` calls; then another takes its place. It ends with this
    process, however that ends. Unlike those of `multiprocessing` it can be had by a
    process that is a daemon itself, as a cluster's workers are, and does not import the
    caller's main module.

    Args:
        function: Importable by name; it, its arguments and what it returns are pickled.
        arguments: What to call it with.

    Raises:
        ProcessDied: if the child did; `NeverBegan` if it was not yet in the function.
        OSError: if there is no process to be had.
        Exception: what the function raises.
    """
    child = getattr(_own, "child", None)
    if child is None or child.is_spent:
        child = _own.child = _Child()
    result, error = child.call(function, arguments)
    if error is not None:
        raise error
    return result


def end_children() -> None:
    """Ends all children of this process at once, whatever they do: their calls raise."""
    for child in list(_children):
        child.kill()


class _Child:
    """A process that waits for calls, as its parent's end of a pipe."""

    def __init__(self):
        self._pipe, theirs = Pipe()
        # Where this process finds its modules the child does.
        path = os.pathsep.join(place or os.getcwd() for place in sys.path)
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "aerodrake.sweeps.child", str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                env={**os.environ, "PYTHONPATH": path},
                stdin=subprocess.DEVNULL,
                process_group=0,  # Ctrl-C is for the parent.
            )
        self._calls = 0
        _children.add(self)

    @property
    def is_spent(self) -> bool:
        """Whether it takes no more calls."""
        if self._process.poll() is not None:
            _children.discard(self)
        return self not in _children

    def call(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """(result, None) or (None, error) of one call."""
        self._calls += 1
        has_begun = False
        try:
            self._pipe.send((function, arguments))
            outcome = self._pipe.recv()
            if has_begun := outcome is BEGUN:
                outcome = self._pipe.recv()
        except (EOFError, OSError):
            self.kill()
            cause = f"its process died of {cause_of_death(self._process.returncode)}"
            if has_begun:
                raise ProcessDied(cause) from None
            raise NeverBegan(f"{cause} before it began") from None
        if self._calls == MOST_CALLS:
            self.kill()
        return outcome

    def kill(self) -> None:
        """Ends it, if it has not ended."""
        self._process.kill()
        self._process.wait()
        _children.discard(self)


def main(pipe: Connection) -> None:
    """Takes calls until none comes any more, or nobody is there to call."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def read() -> None:
        with contextlib.suppress(EOFError, OSError):
            while True:
                calls.put(pipe.recv_bytes())
        os._exit(1)  # Whoever called is gone.

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            call = calls.get(timeout=IDLE_S)
        except queue.Empty:
            return
        try:
            function, arguments = pickle.loads(call)
            pipe.send(BEGUN)
            outcome = function(*arguments), None
        except Exception as error:
            outcome = None, error
        pipe.send(outcome)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
