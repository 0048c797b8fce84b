"""Replacement of `run_parallel` of `aerodrake.support.processes` without processes."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any


def in_this_process(
    function: Callable[[Any], Any], items: Sequence[Any], jobs: int
) -> Iterator[tuple[int, Any]]:
    """Yields results as `run_parallel` does, the last item first."""
    for index in reversed(range(len(items))):
        try:
            yield index, function(items[index])
        except Exception as error:
            yield index, error
