"""Flights of a study, a sweep or an error budget, in its folder."""

import os
import weakref
from concurrent.futures import Executor
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from aerodrake.api.console import Console
from aerodrake.api.jobs import checked_jobs
from aerodrake.api.study_result import StudyResult
from aerodrake.flight.notes import scenario_notes
from aerodrake.support.errors import BadInput
from aerodrake.support.scratch import temporary_folder
from aerodrake.sweeps.cluster import cluster
from aerodrake.sweeps.folder import SweepFolder, sweep_folder
from aerodrake.sweeps.loop import fly_trials, processes
from aerodrake.sweeps.plan import Plan

Result = TypeVar("Result", bound=StudyResult)


@dataclass(frozen=True)
class Engine:
    """Arguments that select the executor of a study's flights.

    Attributes:
        jobs: Number of concurrent processes; None for the number of cores.
        scheduler: Address of a Dask scheduler whose cluster flies the trials; None for processes
            on this machine.
        executor: Executor of `concurrent.futures` that flies the trials instead; None for none.

    Raises:
        BadInput: if they are invalid or contradict each other.
    """

    jobs: int | None
    scheduler: str | None
    executor: Executor | None

    def __post_init__(self) -> None:
        """Checks the arguments."""
        checked_jobs(self.jobs)
        if self.executor is not None and self.scheduler is not None:
            raise BadInput("executor", "", "expected no scheduler beside it")

    def start(self) -> AbstractContextManager[Executor]:
        """Returns the context manager of the executor."""
        if self.executor is not None:
            return nullcontext(self.executor)
        if self.scheduler is not None:
            return cluster(self.scheduler)
        return processes(checked_jobs(self.jobs))


def run_study(
    plan: Plan,
    out: str | os.PathLike[str] | None,
    resume: bool,
    engine: Engine,
    console: Console,
    result: type[Result],
) -> Result:
    """Flies the trials of a plan that have no row yet, and writes the results.

    Args:
        plan: The plan.
        out: Folder of the study; None for a temporary one that lasts as long as the result.
        resume: True to continue the study in `out`.
        engine: Executor of the flights.
        console: For notes and progress.
        result: Class of the result.

    Raises:
        BadInput: if the plan cannot be flown, or the folder or the engine is invalid.
        ProcessDied: if the executor fails, or the disk is full.
    """
    kind = plan.files.kind
    if resume and out is None:
        raise BadInput("resume", "", f"expected the folder of a {kind} as `out`")
    plan.check()
    console.note(scenario_notes(plan.scenario))
    with ExitStack() as stack:
        target = stack.enter_context(temporary_folder()) / kind if out is None else Path(out)
        with engine.start() as executor, sweep_folder(target, plan, resume) as folder:
            _fly(console, folder, executor)
            finished = result(result.write(folder), target)
        weakref.finalize(finished, stack.pop_all().close)
    return finished


def _fly(console: Console, folder: SweepFolder, executor: Executor) -> None:
    """Flies the trials that have no row yet, with a progress bar."""
    endings: dict[str, int] = {}
    name, trials = folder.plan.scenario.name, folder.plan.trials
    with console.bar(name, trials, "trial", initial=len(folder.recorded)) as bar:

        def progress(row: dict[str, Any]) -> None:
            reason = row["exit_reason"]
            if reason != "completed":
                endings[reason] = endings.get(reason, 0) + 1
                bar.set_postfix(endings, refresh=False)
            bar.update()

        fly_trials(folder, executor, progress)
