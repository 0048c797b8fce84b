"""Flight of the trials of a sweep on any executor."""

import queue
from collections.abc import Callable, Iterator
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager
from threading import Thread
from typing import Any

from aerodrake.flight.summary import failure
from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps.child import DiedBeforeCall, call_in_child, kill_children
from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.trial import Trial, fly_trial

MOST_IN_FLIGHT = 1000
"""Largest number of trials that are submitted to the executor at a time."""

MOST_DEATHS = 3
"""Number of processes that may die in one trial before it is recorded as failed."""


def sweep(
    folder: SweepFolder,
    executor: Executor,
    progress: Callable[[dict[str, Any]], None] = lambda row: None,
) -> None:
    """Flies the trials that have no row yet, and writes a row for each as it ends.

    Rows depend neither on the executor nor on the order in which trials end. Each thread or
    process of the executor flies its trials in a child process, because Drake's diagrams leak
    memory. A trial whose child dies is flown again, `MOST_DEATHS` times in all.

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
        for trial in missing:
            submit(trial)
            if len(running) < MOST_IN_FLIGHT:
                continue
            _record(ended.get(), running, folder, submit, progress)
        while running:
            _record(ended.get(), running, folder, submit, progress)
    finally:
        left = [future for future in running if not future.cancel()]
        while left := list(wait(left, timeout=0.1).not_done):
            kill_children()


def _record(
    future: Future,
    running: dict[Future, tuple[Trial, int]],
    folder: SweepFolder,
    submit: Callable[[Trial, int], None],
    progress: Callable[[dict[str, Any]], None],
) -> None:
    """Writes the row of a trial that has ended, or submits it again if its process died."""
    trial, deaths = running.pop(future)
    try:
        row, timing = future.result()
    except (CancelledError, BrokenExecutor) as error:
        raise ProcessDied(f"the executor failed: {type(error).__name__}") from None
    except ProcessDied as error:
        if deaths + 1 < MOST_DEATHS:
            submit(trial, deaths + 1)
            return
        if isinstance(error, DiedBeforeCall):
            raise
        row, timing = {**trial.header(), **failure(error)}, None
    except Exception as error:
        cause = failure(error)["exit_cause"].removeprefix("BadInput: ")
        raise ProcessDied(f"trial {trial.index} could not be flown: {cause}") from None
    folder.append(row, timing)
    progress(row)


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """Yields an executor of `jobs` threads, each of which waits for a child process of its own."""
    executor = ThreadPoolExecutor(jobs)
    try:
        yield executor
    finally:
        # After a second interrupt, for example, flights are still in progress: they are killed.
        ending = Thread(target=executor.shutdown, kwargs={"cancel_futures": True})
        ending.start()
        while ending.is_alive():
            kill_children()
            ending.join(0.05)
