"""Figure of an error budget: a waterfall of the costs, and what each flaw's absence saves."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.budgets.outcomes import BudgetOutcomes, Errors
from aerodrake.flight.summary import HEADLINES
from aerodrake.reports.figures import ACCENT, EDGE, INK, STYLE, write_png

WIDTH_IN, ROW_IN, FRAME_IN = 12.0, 0.27, 1.9
TOTAL, COST, GAIN = INK, ACCENT, "#2b8a3e"
"""Colors of totals, of what adds to the error, and of what reduces it."""
BAR = 0.62
"""Height of a bar as a fraction of its row."""


def plot_budget(outcomes: BudgetOutcomes, bound_m: float, title: str, path: Path) -> None:
    """Writes the figure of an error budget as PNG.

    Args:
        outcomes: Errors of all cases.
        bound_m: m, bound of the error with all flaws.
        title: Plain text.
        path: Path of the file.
    """
    names = ["without flaws", *(cost.name for cost in outcomes.costs), "together", "all flaws"]
    with rc_context(STYLE):
        size = WIDTH_IN, FRAME_IN + ROW_IN * len(names)
        figure = Figure(figsize=size, dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        left, right = figure.subplots(1, 2, sharey=True, width_ratios=(1.5, 1))
        _draw_waterfall(left, outcomes, bound_m)
        _draw_savings(right, outcomes)
        left.set_yticks(range(len(names)), names)
        left.set_ylim(len(names) - 0.4, -0.6)
        figure.supxlabel(f"end-effector error, {HEADLINES[outcomes.key]}, in mm", fontsize=9)
        write_png(figure, path)


def _draw_waterfall(axes: Axes, outcomes: BudgetOutcomes, bound_m: float) -> None:
    """Draws the error without flaws, what each flaw alone adds, and the error with all.

    The row `together` closes the gap between the sum of what they add and the error with all.
    """
    axes.set_title("Each flaw alone: what it adds to the error without flaws", loc="left")
    level = _mm(outcomes.clean.mean_m)
    axes.barh(0, level, BAR, color=TOTAL)
    _label(axes, 0, level, outcomes.clean)
    for row, cost in enumerate(outcomes.costs, 1):
        level = _draw_step(axes, row, level, _mm(cost.added.mean_m))
        _label(axes, row, level, cost.added, "+")
    last = len(outcomes.costs) + 2
    total = _mm(outcomes.all.mean_m)
    if np.isfinite(outcomes.all.mean_m):  # A flight with all flaws was completed.
        reached = _draw_step(axes, last - 1, level, total - level)
        _text(axes, last - 1, max(level, reached), f"{total - level:+.3g}")
    axes.barh(last, total, BAR, color=TOTAL)
    _label(axes, last, total, outcomes.all)
    if bound_m:
        axes.axvline(_mm(bound_m), color=GAIN, linestyle="--")
        note = f"best estimate of the base: {_mm(bound_m):.3g}"
        axes.annotate(
            note,
            (_mm(bound_m), last + 0.55),
            color=GAIN,
            fontsize=8,
            ha="left",
            xytext=(4, 0),
            textcoords="offset points",
        )
    axes.set_xlim(0, 1.18 * max(axes.get_xlim()[1], 1e-3))


def _draw_savings(axes: Axes, outcomes: BudgetOutcomes) -> None:
    """Draws by how much the error with all flaws falls without each of them."""
    axes.set_title("All flaws but one: what its absence saves", loc="left")
    axes.axvline(0.0, color=EDGE)
    for row, cost in enumerate(outcomes.costs, 1):
        saved = 1e3 * cost.saved.by_seed_m
        mean = _mm(cost.saved.mean_m)
        axes.barh(row, mean, BAR, color=COST if mean >= 0 else GAIN)
        axes.plot(saved, np.full(len(saved), row), ".", color=INK, markersize=3)
        shown = [mean, *saved[np.isfinite(saved)], 0.0]
        _text(axes, row, max(shown), _words(cost.saved, "+"))
    low, high = axes.get_xlim()
    axes.set_xlim(low, high + 0.25 * (high - low))


def _draw_step(axes: Axes, row: int, level: float, step: float) -> float:
    """Draws a floating bar from a level by a step, joined to the row above; returns its end."""
    axes.barh(row, step, BAR, left=level, color=COST if step >= 0 else GAIN)
    axes.plot([level, level], [row - 1 + BAR / 2, row - BAR / 2], color=EDGE, linewidth=0.8)
    return level + step


def _label(axes: Axes, row: int, place: float, errors: Errors, sign: str = "") -> None:
    _text(axes, row, place, _words(errors, sign))


def _words(errors: Errors, sign: str = "") -> str:
    """Returns the mean in mm, and the number of flights that were not completed."""
    mean = _mm(errors.mean_m)
    words: Sequence[str] = [f"{mean:{sign}.3g}"] if np.isfinite(errors.mean_m) else []
    lost = [f"{errors.failed} of {len(errors.by_seed_m)} not completed"] if errors.failed else []
    return ", ".join([*words, *lost])


def _text(axes: Axes, row: int, place: float, text: str) -> None:
    axes.annotate(
        text, (place, row), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8
    )


def _mm(length_m: float) -> float:
    """Returns a length in mm; 0 for NaN, which has no bar."""
    return 1e3 * float(np.nan_to_num(length_m))
