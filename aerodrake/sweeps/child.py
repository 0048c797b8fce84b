"""Function calls in child processes that are reused."""

import contextlib
import logging
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
"""Calls per child. Each leaks a Drake diagram of 7 MB, and a new child takes 4 s to start."""

IDLE_S = 60.0
"""s without a call after which a child ends, even if its caller lives on."""

STARTED = None
"""Message of a child that has imported the function and now calls it."""

_own = threading.local()
_children: set["_Child"] = set()


class DiedBeforeCall(ProcessDied):
    """A child process that died before it called the function."""


def call_in_child(function: Callable[..., Result], *arguments: Any) -> Result:
    """Calls a function in the child process of the calling thread.

    A child is replaced after `MOST_CALLS` calls, and ends with this process, however that ends.
    Unlike a process of `multiprocessing`, a daemon can start it, such as a worker of a cluster,
    and it does not import the caller's main module.

    Args:
        function: Importable by name; function, arguments and result are pickled.
        arguments: Positional arguments of the function.

    Raises:
        ProcessDied: if the child dies; `DiedBeforeCall` if it has not yet called the function.
        OSError: if no process can be started.
        Exception: as raised by the function.
    """
    child = getattr(_own, "child", None)
    if child is None or child.is_spent:
        child = _own.child = _Child()
    result, error = child.call(function, arguments)
    if error is not None:
        raise error
    return result


def kill_children() -> None:
    """Kills all children of this process; calls in progress raise ProcessDied."""
    for child in list(_children):
        child.kill()


class _Child:
    """Child process that executes calls, and the parent's end of the pipe to it."""

    def __init__(self):
        self._pipe, remote = Pipe()
        # The child imports modules from the same folders.
        path = os.pathsep.join(folder or os.getcwd() for folder in sys.path)
        with remote:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", "aerodrake.sweeps.child", str(remote.fileno())],
                pass_fds=[remote.fileno()],
                env={**os.environ, "PYTHONPATH": path},
                stdin=subprocess.DEVNULL,
                process_group=0,  # Ctrl-C goes to the parent alone.
            )
        self._calls = 0
        _children.add(self)

    @property
    def is_spent(self) -> bool:
        """Returns True if the child takes no more calls."""
        if self._process.poll() is not None:
            _children.discard(self)
        return self not in _children

    def call(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        """Returns (result, None) or (None, error) of one call."""
        self._calls += 1
        has_started = False
        try:
            self._pipe.send((function, arguments))
            outcome = self._pipe.recv()
            if has_started := outcome is STARTED:
                outcome = self._pipe.recv()
        except (EOFError, OSError):
            self.kill()
            cause = f"its process died of {cause_of_death(self._process.returncode)}"
            if has_started:
                raise ProcessDied(cause) from None
            raise DiedBeforeCall(f"{cause} before the call") from None
        if self._calls == MOST_CALLS:
            self.kill()
        return outcome

    def kill(self) -> None:
        """Kills the process if it is alive."""
        self._process.kill()
        self._process.wait()
        _children.discard(self)


def main(pipe: Connection) -> None:
    """Executes calls until the parent ends, or no call comes for `IDLE_S`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    logging.disable(logging.WARNING)  # The parent has logged the warnings on the same vehicle.
    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()

    def read() -> None:
        with contextlib.suppress(EOFError, OSError):
            while True:
                calls.put(pipe.recv_bytes())
        os._exit(1)  # The parent has ended.

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            call = calls.get(timeout=IDLE_S)
        except queue.Empty:
            return
        try:
            function, arguments = pickle.loads(call)
            pipe.send(STARTED)
            outcome = function(*arguments), None
        except Exception as error:
            outcome = None, error
        pipe.send(outcome)


if __name__ == "__main__":
    main(Connection(int(sys.argv[1])))
