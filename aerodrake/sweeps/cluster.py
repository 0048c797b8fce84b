"""Executor of a Dask cluster."""

import logging
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from aerodrake.support.errors import BadInput
from aerodrake.support.version import __version__

SCHEDULER = "scheduler"
"""Argument that errors name."""

TIMEOUT_S = 10.0
"""s, timeout of the connection to the scheduler."""


@contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """Yields an executor of a running Dask cluster, which keeps running afterwards.

    Each thread of its workers flies in a child process, which ends after a minute without calls.

    Args:
        address: Address of the scheduler, such as tcp://127.0.0.1:8786.

    Raises:
        BadInput: if `distributed` is not installed, the scheduler does not respond, or a worker
            does not have this version of aerodrake.
    """
    try:
        from distributed import Client
        from distributed.comm import get_address_host_port
    except ImportError:
        message = "expected the extra [cluster]: pip install 'aerodrake[cluster]'"
        raise BadInput(SCHEDULER, "", message) from None
    for logger in ("distributed", "distributed.client"):  # Errors are reported below.
        logging.getLogger(logger).setLevel(logging.CRITICAL)
    try:
        get_address_host_port(address)  # A client of an invalid address never ends.
        client = Client(address, timeout=TIMEOUT_S, set_as_default=False)
    except (OSError, ValueError, NotImplementedError) as error:
        reason = f"expected the address of a Dask scheduler: no response from {address}: {error}"
        raise BadInput(SCHEDULER, "", reason) from None
    try:
        _check_workers(client)
        yield client.get_executor(pure=False)
    finally:
        client.close(timeout=TIMEOUT_S)


def installed() -> str:
    """Returns the version of aerodrake on the machine that calls this."""
    return __version__


def _check_workers(client) -> None:
    try:
        versions = client.run(installed, on_error="return")
    except Exception as error:  # Lost connections raise many types.
        raise BadInput(SCHEDULER, "", f"expected workers that respond: {error}") from None
    for worker, version_there in versions.items():
        if version_there != installed():
            expected = f"expected aerodrake {installed()} on worker {worker}, got {version_there!r}"
            raise BadInput(SCHEDULER, "", expected)
