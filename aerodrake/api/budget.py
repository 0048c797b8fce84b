"""Error budget: what each flaw of a scenario costs."""

import os
from collections.abc import Mapping
from concurrent.futures import Executor
from typing import Any

from aerodrake.api.budget_result import BudgetResult
from aerodrake.api.console import Console
from aerodrake.api.study import Engine, run_study
from aerodrake.budgets.plan import BudgetPlan
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import resolve
from aerodrake.support.arguments import checked


@checked
def budget(
    scenario: Scenario | str | os.PathLike[str],
    overrides: Mapping[str, Any] | None = None,
    *,
    seeds: int = 5,
    out: str | os.PathLike[str] | None = None,
    resume: bool = False,
    jobs: int | None = None,
    scheduler: str | None = None,
    executor: Executor | None = None,
    quiet: bool = False,
    **keys: Any,
) -> BudgetResult:
    """Flies a scenario without flaws, with each of its flaws alone, with all, and without each.

        result = aerodrake.budget("clover_realistic", seeds=3)
        print(result)

    Flaws are those of `aerodrake.budgets.flaws`. The summary also has the bound of
    `aerodrake.budgets.bound`, below which no controller with the scenario's sensors can be.

    Args:
        scenario, overrides, keys: As for `aerodrake.fly`.
        seeds: Number of seeds, which count up from the scenario's. A set of flaws without random
            ones is flown with the first alone.
        out: Folder of the budget; None for a temporary one that lasts as long as the result.
        resume: True to continue the budget in `out`, or to add seeds to it.
        jobs, scheduler, executor: As for `aerodrake.sweep`.
        quiet: True to print no notes and show no progress.

    Raises:
        BadInput: if the scenario is invalid or has no flaws, or an argument is invalid.
        ProcessDied: if the executor fails, or the disk is full. `resume` continues the budget.
    """
    engine = Engine(jobs, scheduler, executor)
    plan = BudgetPlan.make(resolve(scenario, overrides, **keys), seeds)
    return run_study(plan, out, resume, engine, Console(quiet), BudgetResult)
