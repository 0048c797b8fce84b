"""One thread inside the loop."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

from threadpoolctl import threadpool_limits


@contextmanager
def single_thread() -> Iterator[None]:
    """Keeps BLAS, and torch where it is imported, to one thread while a diagram is simulated.

    Its matrices are so small that sharing them among threads costs many times
    more than it saves.
    """
    torch = sys.modules.get("torch")  # Not imported for this: it takes a second.
    threads = torch.get_num_threads() if torch else 1
    try:
        if torch:
            torch.set_num_threads(1)
        with threadpool_limits(limits=1):
            yield
    finally:
        if torch:
            torch.set_num_threads(threads)
