"""Computation time of each Python system."""

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
"""Methods of LeafSystem that take callbacks of Python systems."""

SystemTimes = dict[str, float]
"""s, by the name of the module that defines the system."""


class _Stopwatch:
    """Measures the exclusive time of each system: without nested calls of other systems."""

    def __init__(self) -> None:
        self.seconds: SystemTimes = defaultdict(float)
        self._nested_s: list[float] = []

    def timed(self, name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Returns the callback with timing, which adds about 0.5 us per call."""

        @functools.wraps(callback)
        def timed_callback(*arguments: Any) -> Any:
            self._nested_s.append(0.0)
            start = time.perf_counter()
            try:
                return callback(*arguments)
            finally:
                whole = time.perf_counter() - start
                self.seconds[name] += whole - self._nested_s.pop()
                if self._nested_s:
                    self._nested_s[-1] += whole

        return timed_callback


@contextmanager
def timed_systems() -> Iterator[SystemTimes]:
    """Times the callbacks of every Python system that is built in this context.

    The time of an output that another system's update evaluates is that of the system that
    computes it. Time that Drake spends between callbacks is not included.
    """
    stopwatch = _Stopwatch()
    originals = {name: getattr(LeafSystem, name) for name in DECLARATIONS}

    def timing(original: Callable[..., Any]) -> Callable[..., Any]:
        def declare(system: LeafSystem, *arguments: Any, **named: Any) -> Any:
            module = type(system).__module__.rpartition(".")[2]
            # Allocators are timed as well, but called only once.
            wrapped = [stopwatch.timed(module, a) if callable(a) else a for a in arguments]
            named = {k: stopwatch.timed(module, a) if callable(a) else a for k, a in named.items()}
            return original(system, *wrapped, **named)

        return declare

    for name, original in originals.items():
        setattr(LeafSystem, name, timing(original))
    try:
        yield stopwatch.seconds
    finally:
        for name, original in originals.items():
            setattr(LeafSystem, name, original)
