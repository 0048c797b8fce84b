"""Summary, table and figure of an error budget."""

from collections.abc import Mapping
from typing import Any

from aerodrake.budgets.bound import error_bound
from aerodrake.budgets.figure import plot_budget
from aerodrake.budgets.flaws import silence
from aerodrake.budgets.outcomes import BudgetOutcomes, Errors
from aerodrake.budgets.plan import BudgetPlan
from aerodrake.flight.summary import HEADLINES, rounded, to_json
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.reports.drawing import drawing
from aerodrake.support.files import write_atomically
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.outcomes import three_digits

COLUMNS = {"alone": "alone", "added": "adds", "without": "without it", "saved": "saves"}
"""Titles of the columns by the parts of a flaw's cost."""

WIDTHS = (18, 12, 12, 14, 12)


def write_budget(folder: SweepFolder) -> dict[str, Any]:
    """Writes `budget_summary.json`, which finishes a budget, and the figure; returns the summary.

    Raises:
        BadInput: if the summary cannot be written.
    """
    plan: BudgetPlan = folder.plan
    outcomes = BudgetOutcomes.read(folder.path, plan)
    summary = summarize_budget(outcomes, plan)
    title = f"{plan.scenario.name}: what each flaw costs, mean of {plan.seeds} seeds"
    if plan.seeds == 1:
        title = f"{plan.scenario.name}, seed {plan.scenario.seed}: what each flaw costs"
    with deferred_interrupts():
        write_atomically(folder.path / plan.files.summary, to_json(summary).encode())
        path = folder.path / plan.files.figure
        with drawing(path):
            plot_budget(outcomes, summary["bound_m"], title, path)
    return summary


def summarize_budget(outcomes: BudgetOutcomes, plan: BudgetPlan) -> dict[str, Any]:
    """Returns the content of `budget_summary.json`.

    Keys:
        seeds: Number of seeds.
        error: Key of the headline error in a row's `error`.
        bound_m: m, bound of `aerodrake.budgets.bound` for the scenario's sensors and gusts.
        clean, all: Errors without flaws and with all: mean over the seeds in m, by seed, and the
            number of flights that were not completed.
        costs: For each flaw its keys, the errors `alone` and `without` it, and the differences
            `added` (alone, beyond clean) and `saved` (all, beyond without).
    """
    scenario = plan.scenario
    flaws = {case.flaw.name: case.flaw for case in plan.cases if case.flaw}
    return {
        **plan.as_mapping(),
        "seeds": plan.seeds,
        "error": outcomes.key,
        "bound_m": rounded(error_bound(scenario, VehicleModel.load(scenario))),
        "clean": _mapping(outcomes.clean),
        "all": _mapping(outcomes.all),
        "costs": [
            {
                "flaw": cost.name,
                "keys": [*silence([flaws[cost.name]])],
                **{part: _mapping(getattr(cost, part)) for part in COLUMNS},
            }
            for cost in outcomes.costs
        ],
    }


def budget_table(summary: Mapping[str, Any]) -> str:
    """Formats a summary, as from `summarize_budget`, for a terminal."""
    headline = HEADLINES[summary["error"]]
    several, only = f"mean of {summary['seeds']} seeds", f"seed {summary['seed']}"
    title = f"{summary['scenario']}: end-effector error, {headline}, in mm; "
    title += several if summary["seeds"] > 1 else only
    lines = [title, "", _line(["flaw", *COLUMNS.values()])]
    lines.append(_line(["none", _cell(summary["clean"]), "", "", ""]))
    for cost in summary["costs"]:
        lines.append(_line([cost["flaw"], *(_cell(cost[part]) for part in COLUMNS)]))
    lines.append(_line(["all", _cell(summary["all"]), "", "", ""]))
    if summary["bound_m"]:
        bound = three_digits(1e3 * summary["bound_m"])
        lines += ["", f"best estimate of the base with these sensors and gusts: {bound} mm"]
    return "\n".join(lines)


def _mapping(errors: Errors) -> dict[str, Any]:
    by_seed = [rounded(error) for error in errors.by_seed_m]
    return {"mean_m": rounded(errors.mean_m), "by_seed_m": by_seed, "not_completed": errors.failed}


def _cell(errors: Mapping[str, Any]) -> str:
    """Returns the mean in mm, and in brackets the number of flights that were not completed."""
    mean_m, failed = errors["mean_m"], errors["not_completed"]
    text = "" if mean_m is None else f"{1e3 * mean_m:.3f}"
    return f"{text} ({failed} lost)".strip() if failed else text


def _line(cells: list[str]) -> str:
    text = f"{cells[0]:<{WIDTHS[0]}}"
    return (
        text + "".join(f"{c:>{w}}" for c, w in zip(cells[1:], WIDTHS[1:], strict=True))
    ).rstrip()
