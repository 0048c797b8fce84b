"""Flights in wall time: measurement of ticks, and no delays by Python's garbage collector."""

import gc
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any


@contextmanager
def frozen_garbage() -> Iterator[None]:
    """Exempts all current objects from garbage collection.

    Traversing the modules and diagrams of a flight takes 0.1 to 0.2 s, which is five to ten
    ticks. New objects are collected as usual.
    """
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def time_ticks(controller: Any) -> list[float]:
    """Times each call of a `KinematicController`'s method `solve_tick`, by wrapping it.

    Returns:
        List to which each call appends its wall time in ms, which never feeds back into the
        simulation. It remains empty for a system without that method.
    """
    times_ms: list[float] = []
    if solve_tick := getattr(controller, "solve_tick", None):

        def timed(*arguments: Any) -> Any:
            start = time.perf_counter()
            solution = solve_tick(*arguments)
            times_ms.append(1e3 * (time.perf_counter() - start))
            return solution

        controller.solve_tick = timed
    return times_ms
