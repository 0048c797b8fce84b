"""Figure of a sweep: distribution of the error, and error against each varied key."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.summary import HEADLINES
from aerodrake.reports.drawable import LARGEST
from aerodrake.reports.figures import ACCENT, INK, STYLE, write_png
from aerodrake.scenario.plain_yaml import dump_line
from aerodrake.sweeps.distributions import Choice, Linspace, are_numbers
from aerodrake.sweeps.outcomes import Outcomes, three_digits

COLUMNS, MOST_PANELS = 3, 12
PANEL_IN = (4.6, 3.4)
POINTS: dict[str, Any] = {"linestyle": "", "marker": ".", "alpha": 0.6, "color": INK}
ENDED: dict[str, Any] = {"linestyle": "", "marker": "x", "color": ACCENT}
MEDIANS: tuple[dict[str, Any], ...] = (
    {"linewidth": 1.0},
    {"linestyle": "", "marker": "_", "markersize": 24},
)
"""Styles of the medians of a grid, and of a choice."""
MOST_UPRIGHT = 8
"""Largest number of categories with upright labels."""
WIDEST = 100.0
"""Largest ratio of the errors on a linear axis."""
QUANTILES = (50, 90, 95)
TOP = 0.95
"""Height of the marks of flights that were not completed, as a fraction of the panel."""


def plot_sweep(outcomes: Outcomes, title: str, path: Path) -> None:
    """Writes the figure of a sweep as PNG; `title` is plain text."""
    names = list(outcomes.parameters)[: MOST_PANELS - 1]
    columns = min(COLUMNS, 1 + len(names))
    rows = math.ceil((1 + len(names)) / columns)
    with rc_context(STYLE):
        size = PANEL_IN[0] * max(columns, 2), PANEL_IN[1] * rows + 0.4
        figure = Figure(figsize=size, dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        _draw_distribution(panels[0], outcomes)
        for axes, name in zip(panels[1:], names, strict=False):
            _draw_parameter(axes, outcomes, name)
        for axes in panels[1 + len(names) :]:
            axes.set_axis_off()
        if names and not outcomes.completed.all():
            panels[0].plot([], [], label="not completed", **ENDED)
            figure.legend(loc="outside lower center")
        write_png(figure, path)


def _draw_distribution(axes: Axes, outcomes: Outcomes) -> None:
    """Draws the cumulative distribution of the error of completed flights."""
    axes.set(xlabel=_label(outcomes), ylabel="fraction of completed flights", ylim=(0, 1.02))
    error = _error_mm(outcomes)
    error = np.sort(error[np.isfinite(error)])
    if not len(error):
        return
    fraction = np.arange(1, len(error) + 1) / len(error)
    axes.step(np.append(error[0], error), np.append(0, fraction), where="post", color=INK)
    if _spans_decades(error):
        axes.set_xscale("log")
    values = np.percentile(error, QUANTILES)
    for value in values:
        axes.axvline(value, color=ACCENT, linewidth=0.8)
    labels = [f"{q} %: {three_digits(v)}" for q, v in zip(QUANTILES, values, strict=True)]
    axes.set_title("    ".join(labels), color=ACCENT, fontsize=9, loc="left")


def _draw_parameter(axes: Axes, outcomes: Outcomes, name: str) -> None:
    """Draws error against the values of a key, with medians of the values that recur."""
    kind, error = type(outcomes.vary[name]), _error_mm(outcomes)
    axes.set_xlabel(name, parse_math=False)
    axes.set_ylabel(_label(outcomes))
    values = outcomes.parameters[name]
    x = _categories(axes, values) if kind is Choice else np.array(values, dtype=float)
    places = np.unique(x) if kind in (Choice, Linspace) else np.empty(0)
    medians = [_median(error[x == place]) for place in places]
    axes.plot(places, medians, color=ACCENT, **MEDIANS[kind is Choice])
    axes.plot(x, error, **POINTS)
    if _spans_decades(error):
        axes.set_yscale("log")
    else:
        axes.margins(y=0.15)
    ended = x[~outcomes.completed]
    axes.plot(ended, np.full(len(ended), TOP), transform=axes.get_xaxis_transform(), **ENDED)
    if correlation := outcomes.correlation(name):
        axes.set_title(f"rank correlation {correlation[0]:+.2f}", fontsize=9, color=INK)


def _categories(axes: Axes, values: Sequence[Any]) -> np.ndarray:
    """Labels an axis with the distinct `values`, in order; returns (T,) the place of each."""
    by_word = {dump_line(value): value for value in values}
    words = sorted(by_word, key=by_word.get) if are_numbers(*values) else sorted(by_word)
    rotation = 90 if len(words) > MOST_UPRIGHT else 0
    labels = [word[:20] for word in words]
    axes.set_xticks(range(len(words)), labels, parse_math=False, rotation=rotation)
    axes.set_xlim(-0.5, max(len(words), 1) - 0.5)
    return np.array([words.index(dump_line(value)) for value in values], dtype=float)


def _error_mm(outcomes: Outcomes) -> np.ndarray:
    """Returns (T,) mm, errors of the completed flights; NaN for others, and for diverged ones."""
    return np.where(outcomes.error_m <= LARGEST, 1e3 * outcomes.error_m, np.nan)


def _median(error: np.ndarray) -> float:
    error = error[np.isfinite(error)]
    return float(np.median(error)) if len(error) else np.nan


def _spans_decades(error: np.ndarray) -> bool:
    """Returns True for errors so different that only a logarithmic axis shows all."""
    error = error[np.isfinite(error)]
    return bool(len(error) and error.min() > 0 and error.max() > WIDEST * error.min())


def _label(outcomes: Outcomes) -> str:
    return f"end-effector error, {HEADLINES[outcomes.key]} / mm"
