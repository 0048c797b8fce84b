"""Summary, table and figure of a sweep."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from aerodrake.flight.summary import HEADLINES, rounded, to_json
from aerodrake.reports.drawing import drawing
from aerodrake.support.files import write_atomically
from aerodrake.support.interrupts import deferred_interrupts
from aerodrake.sweeps.figure import plot_sweep
from aerodrake.sweeps.folder import SweepFolder
from aerodrake.sweeps.outcomes import Outcomes, three_digits
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import SCENARIO

QUANTILES = {"median_m": 50, "p90_m": 90, "p95_m": 95, "max_m": 100}

WORST = 5

NARROWEST = 38
"""Smallest width of the column of names in the table."""


def write_report(folder: SweepFolder) -> dict[str, Any]:
    """Writes `sweep_summary.json`, which finishes a sweep, and the figure; returns the summary.

    Raises:
        BadInput: if the summary cannot be written.
    """
    outcomes = Outcomes.read(folder.path, folder.plan)
    summary = summarize_sweep(outcomes, folder.plan, folder.path)
    title = f"{summary['scenario']}, {summary['trials']} trials, seed {summary['seed']}"
    with deferred_interrupts():
        write_atomically(folder.path / folder.plan.files.summary, to_json(summary).encode())
        path = folder.path / folder.plan.files.figure
        with drawing(path):
            plot_sweep(outcomes, title, path)
    return summary


def summarize_sweep(outcomes: Outcomes, plan: Plan, folder: Path) -> dict[str, Any]:
    """Returns the content of `sweep_summary.json`.

    Keys:
        endings: Number of flights by exit reason.
        error: Key of the headline error in a row's `error`, and its distribution over the
            completed flights, in m.
        correlations: Spearman's rank correlation of each key with that error, and its p-value,
            or null; flights that were not completed have the worst rank.
        worst: The five worst trials, with the command that flies each alone.
    """
    correlations = {name: outcomes.correlation(name) for name in outcomes.parameters}
    return {
        **plan.as_mapping(),
        "endings": dict(sorted(Counter(outcomes.endings).items())),
        "error": _spread(outcomes),
        "correlations": {
            name: {"spearman": rounded(pair[0]), "p_value": rounded(pair[1])} if pair else None
            for name, pair in correlations.items()
        },
        "worst": [
            {
                "trial": int(outcomes.trials[index]),
                "exit_reason": outcomes.endings[index],
                "error_m": rounded(outcomes.error_m[index]),
                "command": plan.trial(int(outcomes.trials[index])).command(folder / SCENARIO),
            }
            for index in outcomes.worst(WORST)
        ],
    }


def _spread(outcomes: Outcomes) -> dict[str, Any] | None:
    """Returns the distribution of the error of the completed flights; None without any."""
    error = outcomes.error_m[outcomes.completed]
    if not len(error):
        return None
    quantiles = {key: rounded(np.percentile(error, q)) for key, q in QUANTILES.items()}
    return {"key": outcomes.key, "mean_m": rounded(error.mean()), **quantiles}


def sweep_table(summary: Mapping[str, Any]) -> str:
    """Formats a summary, as from `summarize_sweep`, for a terminal."""
    endings = ", ".join(f"{count} {ending}" for ending, count in summary["endings"].items())
    title = f"{summary['scenario']}, seed {summary['seed']}"
    lines = [f"{title}: {summary['trials']} trials, {endings}"]
    error, correlations = summary["error"], summary["correlations"]
    labels = {name: f"  {name}: {summary['vary'][name]}" for name in correlations}
    width = max([NARROWEST, *(len(label) + 1 for label in labels.values())])
    if error:
        titles = ("mean", "median", "90 %", "95 %", "max")
        values = [three_digits(1e3 * error[key]) for key in ("mean_m", *QUANTILES)]
        label = f"end-effector error, {HEADLINES[error['key']]}, mm".replace(", mean,", ",")
        lines += ["", " " * width + "".join(f"{title:>9}" for title in titles)]
        lines += [f"{label:<{width}}" + "".join(f"{value:>9}" for value in values)]
    if correlations:
        lines += ["", f"{'rank correlation with the error':<{width}}{'':9}{'p':>9}"]
    for name, label in labels.items():
        pair = correlations[name]
        cells = f"{pair['spearman']:>+9.2f}{pair['p_value']:>9.0e}" if pair else f"{'-':>9}"
        lines.append(f"{label:<{width}}{cells}")
    lines += ["", "worst trials, with the command that flies each alone"]
    for worst in summary["worst"]:
        error_m = worst["error_m"]
        result = worst["exit_reason"] if error_m is None else f"{three_digits(1e3 * error_m)} mm"
        lines.append(f"  trial {worst['trial']}, {result}: {worst['command']}")
    return "\n".join(lines)
