"""What a person reads of a sweep: its figures, and the table of them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.flight.summary import HEADLINES, millimetres, rounded, to_json
from aerodrake.support.interrupts import held_interrupts
from aerodrake.support.scratch import scratch_folder
from aerodrake.sweeps.figure import plot_sweep
from aerodrake.sweeps.folder import FIGURE, SUMMARY, SweepFolder, writing
from aerodrake.sweeps.match import SCENARIO
from aerodrake.sweeps.outcomes import Outcomes
from aerodrake.sweeps.plan import Plan

QUANTILES = {"median_m": 50, "p90_m": 90, "p95_m": 95, "max_m": 100}

WORST = 5

NARROWEST = 38
"""Column of names in the table."""


def write_report(folder: SweepFolder) -> dict[str, Any]:
    """Writes the figure and `sweep_summary.json`, by which a sweep is finished.

    Returns:
        What the latter holds.

    Raises:
        BadInput: if they cannot be written.
    """
    outcomes = Outcomes.read(folder.path, folder.plan)
    summary = figures(outcomes, folder.plan, folder.path)
    title = f"{summary['scenario']}, {summary['trials']} trials, seed {summary['seed']}"
    with held_interrupts(), writing(folder.path), scratch_folder(folder.path) as scratch:
        plot_sweep(outcomes, title, scratch / FIGURE)
        (scratch / SUMMARY).write_text(to_json(summary), encoding="utf-8")
        for name in (FIGURE, SUMMARY):
            os.replace(scratch / name, folder.path / name)
    return summary


def figures(outcomes: Outcomes, plan: Plan, folder: Path) -> dict[str, Any]:
    """What `sweep_summary.json` holds.

    Keys:
        endings: How many flights ended how.
        error: Which key of a row's `error` it is; its distribution over the
            flights that were completed, in m.
        correlations: By key, Spearman's rank correlation with that error, and
            its p-value; flights that were not completed have the worst rank.
            Null where there is none.
        worst: Of the five worst trials: what flies each alone.

    Args:
        outcomes: Of the sweep's rows.
        plan: Of the sweep.
        folder: The sweep's.
    """
    found = {name: outcomes.correlation(name) for name in outcomes.parameters}
    return {
        **plan.as_mapping(),
        "endings": dict(sorted(Counter(outcomes.endings).items())),
        "error": _spread(outcomes),
        "correlations": {
            name: {"spearman": rounded(pair[0]), "p_value": rounded(pair[1])} if pair else None
            for name, pair in found.items()
        },
        "worst": [
            {
                "trial": int(outcomes.trials[place]),
                "exit_reason": outcomes.endings[place],
                "error_m": rounded(outcomes.error_m[place]),
                "command": plan.trial(int(outcomes.trials[place])).command(folder / SCENARIO),
            }
            for place in outcomes.worst(WORST)
        ],
    }


def _spread(outcomes: Outcomes) -> dict[str, Any] | None:
    """Of the error over the flights that were completed; None if there are none."""
    error = outcomes.error_m[outcomes.completed]
    if not len(error):
        return None
    quantiles = {key: rounded(np.percentile(error, q)) for key, q in QUANTILES.items()}
    return {"key": outcomes.key, "mean_m": rounded(error.mean()), **quantiles}


def sweep_table(summary: Mapping[str, Any]) -> str:
    """The figures of a sweep, for a terminal.

    Args:
        summary: As from `figures`.
    """
    endings = ", ".join(f"{count} {ending}" for ending, count in summary["endings"].items())
    lines = [
        f"{summary['scenario']}, seed {summary['seed']}: {summary['trials']} trials, {endings}"
    ]
    error, found = summary["error"], summary["correlations"]
    spreads = {name: f"  {name}: {summary['vary'][name]}" for name in found}
    width = max([NARROWEST, *(len(spread) + 1 for spread in spreads.values())])
    if error:
        titles = ("mean", "median", "90 %", "95 %", "max")
        values = [millimetres(error[key]) for key in ("mean_m", *QUANTILES)]
        label = f"end-effector error, {HEADLINES[error['key']]}, mm".replace(", mean,", ",")
        lines += ["", " " * width + "".join(f"{title:>9}" for title in titles)]
        lines += [f"{label:<{width}}" + "".join(f"{value:>9}" for value in values)]
    if found:
        lines += ["", f"{'rank correlation with the error':<{width}}{'':9}{'p':>9}"]
    for name, spread in spreads.items():
        pair = found[name]
        cells = f"{pair['spearman']:>+9.2f}{pair['p_value']:>9.0e}" if pair else f"{'-':>9}"
        lines.append(f"{spread:<{width}}{cells}")
    lines += ["", "worst, with what flies each alone"]
    for worst in summary["worst"]:
        error_m = worst["error_m"]
        how = worst["exit_reason"] if error_m is None else f"{millimetres(error_m)} mm"
        lines.append(f"  trial {worst['trial']}, {how}: {worst['command']}")
    return "\n".join(lines)
