"""Figure of a sweep: distribution of the error, and error against each varied key."""

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.summary import HEADLINES
from aerodrake.reports.figures import ACCENT, INK, STYLE, write_png
from aerodrake.scenario.plain_yaml import dump_line
from aerodrake.sweeps.distributions import are_numbers
from aerodrake.sweeps.outcomes import Outcomes

COLUMNS, MOST_PANELS = 3, 12
PANEL_IN = (4.6, 3.4)
POINTS: dict[str, Any] = {"linestyle": "", "marker": ".", "alpha": 0.6, "color": INK}
ENDED: dict[str, Any] = {"linestyle": "", "marker": "x", "color": ACCENT}
MOST_CATEGORIES = 8
"""Largest number of distinct numbers that are drawn as categories."""
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
    error = 1e3 * np.sort(outcomes.error_m[outcomes.completed])
    axes.set(xlabel=_label(outcomes), ylabel="fraction of completed flights", ylim=(0, 1.02))
    if not len(error):
        return
    fraction = np.arange(1, len(error) + 1) / len(error)
    axes.step(np.append(error[0], error), np.append(0, fraction), where="post", color=INK)
    for quantile in (50, 90, 95):
        value = np.percentile(error, quantile)
        axes.axvline(value, color=ACCENT, linewidth=0.8)
        axes.annotate(f" {value:.2f}", (value, quantile / 100), color=ACCENT, fontsize=8, va="top")


def _draw_parameter(axes: Axes, outcomes: Outcomes, name: str) -> None:
    """Draws error against the values of a key; words and few numbers as categories with medians."""
    values, done = outcomes.parameters[name], outcomes.completed
    axes.set_xlabel(name, parse_math=False)
    axes.set_ylabel(_label(outcomes))
    if are_numbers(*values) and len({*values}) > MOST_CATEGORIES:
        x = np.array(values, dtype=float)
    else:
        by_word = {dump_line(v): v for v in values}
        words = sorted(by_word, key=by_word.get) if are_numbers(*values) else sorted(by_word)
        x = np.array([words.index(dump_line(value)) for value in values], dtype=float)
        axes.set_xticks(range(len(words)), [word[:20] for word in words], parse_math=False)
        for category in range(len(words)):
            error = outcomes.error_m[(x == category) & done]
            if len(error):
                axes.plot(category, 1e3 * np.median(error), "_", color=ACCENT, markersize=24)
    axes.plot(x[done], 1e3 * outcomes.error_m[done], **POINTS)
    ended = x[~done]
    axes.plot(ended, np.full(len(ended), TOP), transform=axes.get_xaxis_transform(), **ENDED)
    axes.margins(y=0.15)
    if correlation := outcomes.correlation(name):
        axes.set_title(f"rank correlation {correlation[0]:+.2f}", fontsize=9, color=INK)


def _label(outcomes: Outcomes) -> str:
    return f"end-effector error, {HEADLINES[outcomes.key]} / mm"
