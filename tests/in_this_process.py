"""Replacements of functions that call others in processes, without processes."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any


def in_this_process(
    function: Callable[[Any], Any], items: Sequence[Any], jobs: int
) -> Iterator[tuple[int, Any]]:
    """Yields results as `run_parallel` of `aerodrake.support.processes`, the last item first."""
    for index in reversed(range(len(items))):
        try:
            yield index, function(items[index])
        except Exception as error:
            yield index, error


def call_in_this_process(function: Callable[..., Any], *arguments: Any) -> Any:
    """Calls a function as `call_in_child` of `aerodrake.sweeps.child` does."""
    return function(*arguments)
