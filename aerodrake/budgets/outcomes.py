"""Errors of the flights of an error budget, by case."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np

from aerodrake.budgets.plan import BudgetPlan
from aerodrake.flight.summary import HEADLINES
from aerodrake.sweeps.folder import read_rows


@dataclass(frozen=True)
class Errors:
    """Errors of one case.

    Attributes:
        by_seed_m: (S,) m, headline error with each seed; NaN for a flight that was not completed.
            A case without random flaws has the same with every seed.
    """

    by_seed_m: np.ndarray

    @property
    def failed(self) -> int:
        """Number of seeds whose flight was not completed."""
        return int(np.isnan(self.by_seed_m).sum())

    @property
    def mean_m(self) -> float:
        """Mean in m over the completed flights; NaN without any."""
        completed = self.by_seed_m[np.isfinite(self.by_seed_m)]
        return float(completed.mean()) if len(completed) else np.nan

    def beyond(self, other: Self) -> Self:
        """Returns the differences to the errors of another case, seed by seed."""
        return Errors(self.by_seed_m - other.by_seed_m)


@dataclass(frozen=True)
class FlawCost:
    """Cost of one flaw.

    Attributes:
        name: Name of the flaw.
        alone: Errors with this flaw alone.
        without: Errors with all flaws but this one.
        added: Error with this flaw alone beyond that without any.
        saved: Error with all flaws beyond that without this one.
    """

    name: str
    alone: Errors
    without: Errors
    added: Errors
    saved: Errors


@dataclass(frozen=True)
class BudgetOutcomes:
    """Outcomes of an error budget.

    Attributes:
        key: Key of the headline error in a row's `error`.
        clean: Errors without flaws.
        all: Errors with all flaws.
        costs: Cost of each flaw, the most expensive alone first; flights that were not completed
            are the most expensive.
    """

    key: str
    clean: Errors
    all: Errors
    costs: tuple[FlawCost, ...]

    @classmethod
    def read(cls, folder: Path, plan: BudgetPlan) -> Self:
        """Reads the rows of a budget's folder; each trial has one."""
        rows = {row["trial"]: row for row in read_rows(folder)}
        completed = [row["error"] for row in rows.values() if row["exit_reason"] == "completed"]
        keys = (key for key in HEADLINES if all(error[key] is not None for error in completed))
        key = next(keys, "mean_m")
        by_case = dict(zip(plan.cases, _by_seed(rows, plan, key), strict=True))
        errors = {(case.kind, case.flaw): Errors(by_seed) for case, by_seed in by_case.items()}
        clean, full = errors["clean", None], errors["all", None]
        costs = [
            FlawCost(
                name=case.flaw.name,
                alone=(alone := errors["alone", case.flaw]),
                without=(without := errors["without", case.flaw]),
                added=alone.beyond(clean),
                saved=full.beyond(without),
            )
            for case in plan.cases
            if case.kind == "alone"
        ]
        costs.sort(key=lambda cost: (-cost.alone.failed, -np.nan_to_num(cost.added.mean_m)))
        return cls(key, clean, full, tuple(costs))


def _by_seed(rows: Mapping[int, Any], plan: BudgetPlan, key: str) -> Sequence[np.ndarray]:
    """Returns the errors (S,) m of each case, in the order of `plan.cases`."""
    errors = np.full((len(plan.cases), plan.seeds), np.nan)
    for trial, (case, seed) in enumerate(plan.flights):
        row = rows[trial]
        if row["exit_reason"] != "completed":
            continue
        error, first = row["error"][key], seed - plan.scenario.seed
        errors[case, first if plan.cases[case].is_random else slice(None)] = error
    return [*errors]
