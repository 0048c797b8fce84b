"""Parallel work in isolated processes, one for each item."""

import logging
import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from multiprocessing import connection
from typing import TypeVar

from pebble import ProcessExpired, ProcessPool

from aerodrake.support.errors import ProcessDied

Item = TypeVar("Item")
Result = TypeVar("Result")


def run_parallel(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int
) -> Iterator[tuple[int, Result | Exception]]:
    """Yields (index, result or exception of `function`) as the items finish.

    Each item has its own process, since Drake's diagrams are not freed before their process
    ends. A process that dies fails only its own item, with `ProcessDied`. All processes end if
    the iteration stops, for example by Ctrl-C, or if this process ends or is killed.

    Args:
        function: Importable by name; it and the items are sent to the processes.
        items: Arguments of the calls. Items may be appended during the iteration.
        jobs: Number of concurrent processes.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPool(max_workers=jobs, max_tasks=1, initializer=_follow_parent, context=context)
    try:
        running: dict[Future, int] = {}
        sent = 0
        while sent < len(items) or running:
            for index in range(sent, len(items)):
                running[pool.schedule(function, args=[items[index]])] = index
            sent = len(items)
            future = next(iter(wait(running, return_when=FIRST_COMPLETED).done))
            error = future.exception()
            if isinstance(error, ProcessExpired):
                error = ProcessDied(f"its process died of {cause_of_death(error.exitcode)}")
            yield running.pop(future), future.result() if error is None else error
    finally:
        pool.stop()
        pool.join()


def _follow_parent() -> None:
    """Makes this process end with its parent, even if the parent is killed, and log errors only."""
    logging.disable(logging.WARNING)  # The parent has logged the warnings on the same vehicle.
    parent = multiprocessing.parent_process()

    def watch() -> None:
        connection.wait([parent.sentinel])
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def cause_of_death(exit_code: int) -> str:
    """Returns the name of the signal, or the exit code, with which a process ended."""
    return signal.Signals(-exit_code).name if exit_code < 0 else f"exit code {exit_code}"
