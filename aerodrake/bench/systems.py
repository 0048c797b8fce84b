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


@contextmanager
def timed_systems() -> Iterator[SystemTimes]:
    """Times the callbacks of every Python system that is built in this context.

    Times are exclusive: that of an output that another system's update evaluates counts for the
    system that computes it. Time that Drake spends between callbacks is not included.
    """
    seconds: SystemTimes = defaultdict(float)
    nested_s: list[float] = []  # Time in nested callbacks, for each that runs.

    def timed(name: str, callback: Callable[..., Any]) -> Callable[..., Any]:
        """Returns the callback with timing, which adds about 0.5 us per call."""

        @functools.wraps(callback)
        def timed_callback(*arguments: Any) -> Any:
            nested_s.append(0.0)
            start = time.perf_counter()
            try:
                return callback(*arguments)
            finally:
                whole = time.perf_counter() - start
                seconds[name] += whole - nested_s.pop()
                if nested_s:
                    nested_s[-1] += whole

        return timed_callback

    originals = {name: getattr(LeafSystem, name) for name in DECLARATIONS}

    def timing(original: Callable[..., Any]) -> Callable[..., Any]:
        def declare(system: LeafSystem, *arguments: Any, **named: Any) -> Any:
            module = type(system).__module__.rpartition(".")[2]
            # Allocators are timed as well, but called only once.
            wrapped = [timed(module, a) if callable(a) else a for a in arguments]
            named = {k: timed(module, a) if callable(a) else a for k, a in named.items()}
            return original(system, *wrapped, **named)

        return declare

    for name, original in originals.items():
        setattr(LeafSystem, name, timing(original))
    try:
        yield seconds
    finally:
        for name, original in originals.items():
            setattr(LeafSystem, name, original)
