"""Many flights of one scenario with varied keys."""

import os
import weakref
from collections.abc import Mapping
from concurrent.futures import Executor
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path
from typing import Any

from aerodrake.api.console import Console
from aerodrake.api.jobs import checked_jobs
from aerodrake.api.sweep_result import SweepResult
from aerodrake.flight.notes import scenario_notes
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput
from aerodrake.support.scratch import temporary_folder
from aerodrake.sweeps.cluster import cluster
from aerodrake.sweeps.folder import SweepFolder, sweep_folder
from aerodrake.sweeps.loop import fly_trials, processes
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.report import write_report


@checked
def sweep(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    *,
    vary: Mapping[str, str],
    trials: int | None = None,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    executor: Executor | None = None,
    quiet: bool = False,
    **keys: Any,
) -> SweepResult:
    """Flies a scenario many times, with keys drawn from distributions or on grids.

        result = aerodrake.sweep("hover", vary={"payload.mass_kg": "uniform(0, 0.5)"}, trials=100)
        masses = [row["parameters"]["payload.mass_kg"] for row in result.rows]

    Each trial depends on the scenario's seed, its index and its keys alone. Its row is written to
    `trials.jsonl` when it ends.

    Args:
        scenario, overrides, keys: As for `aerodrake.fly`.
        vary: Distribution of each varied dotted key: `uniform(a, b)`, `normal(mean, std)`,
            `choice(x, y, ...)`, or `linspace(a, b, n)` for a grid.
        trials: Number of flights; None for one for each point of the grid.
        out: Folder of the sweep; None for a temporary one that lasts as long as the result.
        resume: True to continue the sweep in `out`, or to add trials to it.
        jobs: Number of concurrent processes; None for the number of cores.
        scheduler: Address of a Dask scheduler whose cluster flies the trials; None for processes
            on this machine.
        executor: Executor of `concurrent.futures` that flies the trials instead; None for none.
        quiet: True to print no notes and show no progress.

    Raises:
        BadInput: if the scenario, a distribution or the folder is invalid.
        ProcessDied: if the executor fails, or the disk is full. `resume` continues the sweep.
    """
    if resume and out is None:
        raise BadInput("resume", "", "expected the folder of a sweep as `out`")
    if executor is not None and scheduler is not None:
        raise BadInput("executor", "", "expected no scheduler beside it")
    console, jobs = Console(quiet), checked_jobs(jobs)
    scenario = resolve(scenario, overrides, **keys)
    plan = Plan.make(scenario, vary, trials)
    plan.check()
    console.note(scenario_notes(scenario))
    with ExitStack() as stack:
        target = stack.enter_context(temporary_folder()) / "sweep" if out is None else Path(out)
        with (
            _engine(jobs, scheduler, executor) as engine,
            sweep_folder(target, plan, resume) as folder,
        ):
            _fly(console, folder, engine)
            result = SweepResult(write_report(folder), target)
        weakref.finalize(result, stack.pop_all().close)
    return result


def _engine(
    jobs: int, scheduler: str | None, executor: Executor | None
) -> AbstractContextManager[Executor]:
    if executor is not None:
        return nullcontext(executor)
    return processes(jobs) if scheduler is None else cluster(scheduler)


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
