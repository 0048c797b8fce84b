"""Work in parallel processes: one process an item, none of which can harm another."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import as_completed
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
        items: What to call it with.
        jobs: How many processes at a time.
    """
    context = multiprocessing.get_context("spawn")
    pool = ProcessPool(max_workers=jobs, max_tasks=1, context=context)
    try:
        futures = {pool.schedule(function, args=[item]): i for i, item in enumerate(items)}
        for future in as_completed(futures):
            error = future.exception()
            yield futures[future], future.result() if error is None else error
    finally:
        pool.stop()
        pool.join()
