"""Flying the trials of a sweep on whatever runs functions."""

from __future__ import annotations

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
from aerodrake.sweeps.child import NeverBegan, apart, end_children
from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.trial import Trial, fly_trial

MOST_IN_FLIGHT = 1000
"""Trials that are handed to the executor at a time."""

MOST_DEATHS = 3
"""Of the processes of one trial: then it is a row like any other."""


def sweep(
    folder: SweepFolder,
    executor: Executor,
    progress: Callable[[dict[str, Any]], None] = lambda row: None,
) -> None:
    """Flies the trials that have no row yet; writes a row for each as it ends.

    Rows do not depend on the executor or on the order in which trials end. Each thread
    or process of the executor has its trials flown by a child of its own, so that no
    memory is lost there; a trial whose child was killed is flown again, three times in all.

    Args:
        folder: As from `sweep_folder`; its plan is what is flown.
        executor: Any of `concurrent.futures`: `processes(jobs)`, that of a Dask cluster,
            `mpi4py.futures.MPIPoolExecutor`, ...
        progress: Called with each row that was written.

    Raises:
        ProcessDied: if the executor gives up, or what is no trial's own keeps one from being
            flown, such as a full disk. It has no row then.
        BadInput: if a row cannot be written.
    """
    running: dict[Future, tuple[Trial, int]] = {}
    ended: queue.SimpleQueue[Future] = queue.SimpleQueue()

    def submit(trial: Trial, deaths: int = 0) -> None:
        future = executor.submit(apart, fly_trial, trial)
        running[future] = trial, deaths
        future.add_done_callback(ended.put)

    plan = folder.plan
    missing = (plan.trial(i) for i in range(plan.trials) if i not in folder.flown)
    try:
        for trial in missing:
            submit(trial)
            if len(running) < MOST_IN_FLIGHT:
                continue
            _take(ended.get(), running, folder, submit, progress)
        while running:
            _take(ended.get(), running, folder, submit, progress)
    finally:
        left = [future for future in running if not future.cancel()]
        while left := list(wait(left, timeout=0.1).not_done):
            end_children()


def _take(
    future: Future,
    running: dict[Future, tuple[Trial, int]],
    folder: SweepFolder,
    submit: Callable[[Trial, int], None],
    progress: Callable[[dict[str, Any]], None],
) -> None:
    """Writes what came of a trial, or submits it once more."""
    trial, deaths = running.pop(future)
    try:
        row, timing = future.result()
    except (CancelledError, BrokenExecutor) as error:
        raise ProcessDied(f"what runs the trials has given up: {type(error).__name__}") from None
    except ProcessDied as error:
        if deaths + 1 < MOST_DEATHS:
            submit(trial, deaths + 1)
            return
        if isinstance(error, NeverBegan):
            raise
        row, timing = {**trial.head(), **failure(error)}, None
    except Exception as error:
        cause = failure(error)["exit_cause"].removeprefix("BadInput: ")
        raise ProcessDied(f"trial {trial.index} could not be flown: {cause}") from None
    folder.append(row, timing)
    progress(row)


@contextmanager
def processes(jobs: int) -> Iterator[Executor]:
    """An executor of this machine: so many trials at a time, each in a child process.

    Threads that wait for their children; they end with it.
    """
    executor = ThreadPoolExecutor(jobs)
    try:
        yield executor
    finally:
        # Flights that are still in the air, since whoever took in their rows was interrupted
        # twice, say, are not waited for.
        ending = Thread(target=executor.shutdown, kwargs={"cancel_futures": True})
        ending.start()
        while ending.is_alive():
            end_children()
            ending.join(0.05)
