"""Flight of the trials of a sweep on any executor."""

import queue
from collections.abc import Callable, Iterator
from concurrent import futures
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from itertools import islice
from threading import Thread
from typing import Any

from aerodrake.flight.summary import failure
from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps.child import DiedBeforeCall, call_in_child, kill_children
from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.trial import Trial, fly_trial

Result = tuple[dict[str, Any], dict[str, Any] | None]
"""Row and timing of a trial; no timing if its process died."""

MOST_IN_FLIGHT = 1000
"""Largest number of trials that are submitted to the executor at a time."""

MOST_DEATHS = 3
"""Number of child processes that must die in a trial for it to be recorded as failed."""


def fly_trials(
    folder: SweepFolder,
    executor: Executor,
    progress: Callable[[dict[str, Any]], None] = lambda row: None,
) -> None:
    """Flies the trials that have no row yet, and writes a row for each as it ends.

    Rows depend neither on the executor nor on the order in which trials end. Each thread or
    process of the executor flies its trials in a child process, because Drake's diagrams leak
    memory. A trial whose child dies is flown again, up to `MOST_DEATHS` flights in all.

    Args:
        folder: As from `sweep_folder`, with the plan of the sweep.
        executor: Any executor of `concurrent.futures`: `processes(jobs)`, that of a Dask
            cluster, `mpi4py.futures.MPIPoolExecutor`, ...
        progress: Called with each row that was written.

    Raises:
        ProcessDied: if the executor fails, or a trial cannot be flown for a reason that is not
            its own, such as a full disk. The trial then has no row.
        BadInput: if a row cannot be written.
    """
    running: dict[Future, tuple[Trial, int]] = {}
    ended: queue.SimpleQueue[Future] = queue.SimpleQueue()

    def submit(trial: Trial, deaths: int = 0) -> None:
        future = executor.submit(call_in_child, fly_trial, trial)
        running[future] = trial, deaths
        future.add_done_callback(ended.put)

    plan = folder.plan
    missing = (plan.trial(i) for i in range(plan.trials) if i not in folder.recorded)
    try:
        for trial in islice(missing, MOST_IN_FLIGHT):
            submit(trial)
        while running:
            future = ended.get()
            trial, deaths = running.pop(future)
            result = _result(future, trial, deaths + 1)
            if result is None:
                submit(trial, deaths + 1)
                continue
            folder.append(*result)
            progress(result[0])
            for trial in islice(missing, 1):
                submit(trial)
    finally:
        left = [future for future in running if not future.cancel()]
        while left := list(futures.wait(left, timeout=0.1).not_done):
            kill_children()


def _result(future: Future, trial: Trial, attempts: int) -> Result | None:
    """Returns the result of a trial that has ended; None if it is to be flown again."""
    try:
        return future.result()
    except (futures.CancelledError, futures.BrokenExecutor) as error:
        raise ProcessDied(f"the executor failed: {type(error).__name__}") from None
    except ProcessDied as error:
        if attempts < MOST_DEATHS:
            return None
        if isinstance(error, DiedBeforeCall):
            raise
        return {**trial.header(), **failure(error)}, None
    except Exception as error:
        cause = failure(error)["exit_cause"].removeprefix("BadInput: ")
        raise ProcessDied(f"trial {trial.index} could not be flown: {cause}") from None


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """Yields an executor of `jobs` threads, each of which waits for a child process of its own."""
    executor = futures.ThreadPoolExecutor(jobs)
    try:
        yield executor
    finally:
        # After a second interrupt, for example, flights are still in progress: they are killed.
        ending = Thread(target=executor.shutdown, kwargs={"cancel_futures": True})
        ending.start()
        while ending.is_alive():
            kill_children()
            ending.join(0.05)
