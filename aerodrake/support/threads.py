"""Limit of the threads of numerical libraries."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def single_thread() -> Iterator[None]:
    """Limits BLAS, and torch if it is imported, to one thread.

    The matrices of a diagram are so small that more threads make its simulation much slower.
    """
    torch = sys.modules.get("torch")  # Not imported here, since that takes a second.
    threads = torch.get_num_threads() if torch else 1
    try:
        if torch:
            torch.set_num_threads(1)
        with threadpool_limits(limits=1):
            yield
    finally:
        if torch:
            torch.set_num_threads(threads)
