"""Where a flight's time goes, system by system."""

from __future__ import annotations

import functools
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pydrake.systems.framework import LeafSystem

DECLARATIONS = (
    "DeclareVectorOutputPort",
    "DeclareAbstractOutputPort",
    "DeclarePeriodicDiscreteUpdateEvent",
    "DeclarePeriodicUnrestrictedUpdateEvent",
)
"""Methods of LeafSystem that are handed what a Python system is to compute."""

SystemTimes = dict[str, float]
"""s, by the name of the file that holds the system."""


class _Stopwatch:
    """Gives each call's time to its system, less that of the calls it makes to others."""

    def __init__(self) -> None:
        self.seconds: SystemTimes = defaultdict(float)
        self._others: list[float] = []

    def timed(self, name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """The callback, at the stopwatch's cost of about half a microsecond a call."""

        @functools.wraps(callback)
        def timed_callback(*arguments: Any) -> Any:
            self._others.append(0.0)
            start = time.perf_counter()
            try:
                return callback(*arguments)
            finally:
                whole = time.perf_counter() - start
                self.seconds[name] += whole - self._others.pop()
                if self._others:
                    self._others[-1] += whole

        return timed_callback


@contextmanager
def timed_systems() -> Iterator[SystemTimes]:
    """Times the callbacks of every Python system that is built while this lasts.

    A system's outputs that are pulled by another's update count for the system that
    computes them. What Drake does between the callbacks counts for none.
    """
    stopwatch = _Stopwatch()
    originals = {name: getattr(LeafSystem, name) for name in DECLARATIONS}

    def timing(original: Callable[..., Any]) -> Callable[..., Any]:
        def declare(system: LeafSystem, *arguments: Any, **named: Any) -> Any:
            place = type(system).__module__.rpartition(".")[2]
            # Allocators are not callbacks of the flight; they are timed, and called once.
            wrapped = [stopwatch.timed(place, a) if callable(a) else a for a in arguments]
            named = {k: stopwatch.timed(place, a) if callable(a) else a for k, a in named.items()}
            return original(system, *wrapped, **named)

        return declare

    for name, original in originals.items():
        setattr(LeafSystem, name, timing(original))
    try:
        yield stopwatch.seconds
    finally:
        for name, original in originals.items():
            setattr(LeafSystem, name, original)
