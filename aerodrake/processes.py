"""Work in parallel processes: one process an item, none of which can harm another."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import TypeVar

from pebble import ProcessPool

Item = TypeVar("Item")
Result = TypeVar("Result")


def run_parallel(
    function: Callable[[Item], Result], items: Sequence[Item], jobs: int
) -> Iterator[tuple[int, Result | Exception]]:
    """Yields (index, what `function` returned or raised) as the items finish.

    Each item has a process of its own: Drake's diagrams are never collected
    while theirs lives, and one that dies fails its own item only. Whoever stops
    iterating, as by Ctrl-C, stops them all.

    Args:
        function: Importable by name; it and the items are sent to the processes.
        items: What to call it with. Whoever takes the results may append to them.
        jobs: How many processes at a time.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPool(max_workers=jobs, max_tasks=1, context=context)
    try:
        running: dict[Future, int] = {}
        sent = 0
        while sent < len(items) or running:
            for index in range(sent, len(items)):
                running[pool.schedule(function, args=[items[index]])] = index
            sent = len(items)
            future = next(iter(wait(running, return_when=FIRST_COMPLETED).done))
            error = future.exception()
            yield running.pop(future), future.result() if error is None else error
    finally:
        pool.stop()
        pool.join()
