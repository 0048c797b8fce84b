"""Many flights of one scenario with varied keys."""

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from typing import Any

from aerodrake.api.console import Console
from aerodrake.api.study import Engine, run_study
from aerodrake.api.sweep_result import SweepResult
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked
from aerodrake.sweeps.plan import Plan


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
    engine = Engine(jobs, scheduler, executor)
    plan = Plan.make(resolve(scenario, overrides, **keys), vary, trials)
    return run_study(plan, out, resume, engine, Console(quiet), SweepResult)
