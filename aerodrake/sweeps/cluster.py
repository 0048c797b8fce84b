"""A Dask cluster as an executor."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from importlib.metadata import version

from aerodrake.support.errors import BadInput

SCHEDULER = "--scheduler"

PATIENCE_S = 10.0
"""For the scheduler's answer."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """An executor that is a Dask cluster which is there already; it lives on.

    Its workers fly in children of theirs: one for each thread, which ends when
    it has had nothing to do for a minute.

    Args:
        address: Of the scheduler, such as tcp://127.0.0.1:8786.

    Raises:
        BadInput: if `distributed` is not installed, nobody answers, or a worker
            has another version of aerodrake, or none.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        message = "expected the extra [cluster]: pip install 'aerodrake[cluster]'"
        raise BadInput(SCHEDULER, "", message) from None
    for logger in ("distributed", "distributed.client"):  # What happens is told here, once.
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    try:
        get_address_host_port(address)  # A client that was made of a bad one does not end.
        client = Client(address, timeout=PATIENCE_S, set_as_default=False)
    except (OSError, ValueError, NotImplementedError) as error:
        reason = f"expected the address of a Dask scheduler: no answer from {address}: {error}"
        raise BadInput(SCHEDULER, "", reason) from None
    try:
        _check_workers(client)
        yield client.get_executor(pure=False)
    finally:
        client.close(timeout=PATIENCE_S)


def installed() -> str:
    """The version of aerodrake where this is called."""
    return version("aerodrake")


def _check_workers(client) -> None:
    try:
        found = client.run(installed, on_error="return")
    except Exception as error:  # As many kinds as there are ways to be disconnected.
        raise BadInput(SCHEDULER, "", f"expected workers that answer: {error}") from None
    for worker, answer in found.items():
        if answer != installed():
            expected = f"expected aerodrake {installed()} on worker {worker}, got {answer!r}"
            raise BadInput(SCHEDULER, "", expected)
