"""What a person sees of margins: the table, the figure and the file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.comparison.margin_search import LEAST_ERROR_M, Bracket, Search
from aerodrake.comparison.margins import Margins
from aerodrake.comparison.panels import COLORS
from aerodrake.flight.summary import HEADLINES, millimetres, to_json
from aerodrake.reports.figures import INK, REFERENCE, STYLE, write_png
from aerodrake.scenario import Scenario

FILES = ("margins.json", "margins.png")
"""What margins leave behind, beside the files of their comparison."""

COLUMNS = {
    "delay_s": ("delay, ms", 1e3),
    "thrust_up": ("thrust up, x", 1.0),
    "thrust_down": ("thrust down, x", 1.0),
    "payload_kg": ("payload, kg", 1.0),
}
"""Of the table, by disturbance: title and factor to its unit."""

PANELS = {
    "delay added to all base measurements / ms": ("delay_s",),
    "factor on the rotors' thrust from trim": ("thrust_down", "thrust_up"),
    "payload added / kg": ("payload_kg",),
}
"""Of the figure, by label: the disturbances in it."""

MEANING = (
    "The last value that was flown before the error doubles (x 2), and before it is lost;",
    "with > or < where that did not happen up to the end of the search.",
)
"""Of the table's figures, in two lines."""

NAME, CELL = 18, 8
"""Widths in the table."""


def write_margins(margins: Margins, scenario: Scenario, folder: Path) -> None:
    """Writes `FILES` into the folder.

    Args:
        margins: As from `find_margins`.
        scenario: Whose variants they are of.
        folder: One that exists.
    """
    figures = as_figures(margins, scenario.name)
    (folder / "margins.json").write_text(to_json(figures), encoding="utf-8")
    plot_margins(margins, f"{scenario.name}, seed {scenario.seed}", folder / "margins.png")


def as_figures(margins: Margins, scenario: str) -> dict[str, Any]:
    """What `margins.json` holds.

    Keys:
        error: Which figure of `summary["error"]` it is that doubles.
        variants: By name; then of each disturbance the last value at which the
            error has not doubled (the flight is not lost) and the first at
            which it has; null where there is none. Then all that was flown,
            outward: value, error in m, and how it ended.

    Args:
        margins: As from `find_margins`.
        scenario: Its name.
    """
    return {
        "scenario": scenario,
        "error": margins.key,
        "variants": {
            name: {
                "error_m": margins.outcomes(name)[0].error_m,
                **{what: _search_figures(search) for what, search in searches.items()},
            }
            for name, searches in margins.searches.items()
        },
    }


def _search_figures(search: Search) -> dict[str, Any]:
    ends = ("last_held", "first_crossed")
    return {
        "doubles": dict(zip(ends, search.doubles, strict=True)),
        "lost": dict(zip(ends, search.lost, strict=True)),
        "flown": [
            [search.values[i], outcome.error_m, outcome.exit_reason]
            for i, outcome in sorted(search.flown.items())
        ],
    }


def margins_rows(margins: Margins) -> list[list[str]]:
    """One row for each variant: name, error, both figures of each of `COLUMNS`, and a remark.

    Args:
        margins: As from `find_margins`.
    """
    return [_row(margins, name) for name in margins.searches]


def margins_table(margins: Margins) -> str:
    """How much of each disturbance each variant stands, as text.

    Args:
        margins: As from `find_margins`.
    """
    titles = [f"{title:>{2 * CELL}}" for title, _ in COLUMNS.values()]
    error, pair = f"{HEADLINES[margins.key]:>{CELL}}", f"{'x 2':>{CELL}}{'lost':>{CELL}}"
    lines = [
        *MEANING,
        "",
        f"{'':<{NAME}}{'error':>{CELL}}{''.join(titles)}",
        f"{'':<{NAME}}{error}{pair * len(titles)}",
        f"{'variant':<{NAME}}{'mm':>{CELL}}",
    ]
    for name, *cells, remark in margins_rows(margins):
        line = f"{name:<{NAME}}{''.join(f'{cell:>{CELL}}' for cell in cells)}"
        lines.append(f"{line}{'  ' if remark else ''}{remark}".rstrip())
    return "\n".join(lines)


def _row(margins: Margins, name: str) -> list[str]:
    as_it_is, *others = margins.outcomes(name)
    cells = ["" if as_it_is.error_m is None else millimetres(as_it_is.error_m)]
    for what, (_, factor) in COLUMNS.items():
        search = margins.searches[name][what]
        cells += [_cell(search, bracket, factor) for bracket in (search.doubles, search.lost)]
    failed = [outcome for outcome in others if outcome.exit_reason == "failed"]
    remark = ""
    if as_it_is.is_lost:
        remark = f"{as_it_is.exit_reason}: {as_it_is.exit_cause}"
    elif failed:
        count = "1 flight" if len(failed) == 1 else f"{len(failed)} flights"
        remark = f"{count} failed: {failed[0].exit_cause}"
    return [name, *cells, remark]


def _cell(search: Search, bracket: Bracket, factor: float) -> str:
    held, crossed = bracket
    if held is None:
        return ""
    side = "" if crossed is not None else "< " if held < search.values[0] else "> "
    return f"{side}{factor * held:.4g}"


def plot_margins(margins: Margins, title: str, path: Path) -> None:
    """Writes the figure: error against each disturbance.

    A ring is the last value before the error has doubled, a cross at the top
    the first at which the flight is lost.

    Args:
        margins: As from `find_margins`.
        title: Plain text.
        path: A PNG.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(14, 5.5), dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        draw_margins(figure.subplots(1, len(PANELS), sharey=True, squeeze=False)[0], margins)
        figure.legend(loc="outside lower center", ncols=len(margins.searches))
        write_png(figure, path)


def draw_margins(row: Sequence[Axes], margins: Margins) -> None:
    """Error against each disturbance: one of `row` for each of `PANELS`.

    The first has what a legend needs.
    """
    for axes, (label, disturbances) in zip(row, PANELS.items(), strict=True):
        axes.set_xlabel(label)
        axes.set_yscale("log")
        for name, searches in margins.searches.items():
            for what in disturbances:
                _draw(axes, searches[what], COLUMNS[what][1], COLORS[name])
        if len(disturbances) > 1:
            _factors(axes)
    row[0].set_ylabel("end-effector error / mm")
    for name in margins.searches:
        row[0].plot([], [], color=COLORS[name], label=name)


def _factors(axes: Axes) -> None:
    """An axis of factors up and down."""
    axes.set_xscale("log")
    axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
    axes.minorticks_off()
    axes.axvline(1.0, **REFERENCE)


def _draw(axes: Axes, search: Search, factor: float, color: str) -> None:
    errors = {
        factor * search.values[i]: 1e3 * max(outcome.error_m, LEAST_ERROR_M)
        for i, outcome in sorted(search.flown.items())
        if not outcome.is_lost and outcome.error_m is not None
    }
    axes.plot(list(errors), list(errors.values()), color=color, marker=".", markersize=4)
    held, crossed = search.doubles
    if held is not None and crossed is not None:
        ring = {"marker": "o", "markersize": 8, "markerfacecolor": "none"}
        axes.plot(factor * held, errors[factor * held], color=color, **ring)
    lost = search.lost[1]
    if lost is not None:
        top = axes.get_xaxis_transform()
        axes.plot(factor * lost, 0.98, "x", color=color, transform=top, markersize=7)
