"""Table, figure and JSON file of robustness margins."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.comparison.figure import COLORS
from aerodrake.comparison.margin_search import LEAST_ERROR_M, Bracket, Search
from aerodrake.comparison.margins import Margins
from aerodrake.flight.summary import HEADLINES, millimetres, to_json
from aerodrake.reports.drawable import LARGEST
from aerodrake.reports.figures import INK, REFERENCE, STYLE, write_png
from aerodrake.scenario import Scenario

COLUMNS = {
    "delay_s": ("delay, ms", 1e3),
    "thrust_up": ("thrust up, x", 1.0),
    "thrust_down": ("thrust down, x", 1.0),
    "payload_kg": ("payload, kg", 1.0),
}
"""Title with its unit, and factor to that unit, of each disturbance in the table."""

PANELS = {
    "delay added to all base measurements / ms": ("delay_s",),
    "factor on rotor thrust beyond trim": ("thrust_down", "thrust_up"),
    "payload added / kg": ("payload_kg",),
}
"""Panels of the figure: disturbances, by label."""

MEANING = (
    "Last value flown before the error doubles (x 2), and before a flight is not completed",
    "(lost); > or < marks the end of a search in which that did not happen.",
)
"""Legend of the table, in two lines."""

NAME, CELL = 18, 8
"""Widths in the table."""


def write_margins(margins: Margins, scenario: Scenario, folder: Path) -> None:
    """Writes `margins.json` into the folder.

    Keys of `margins.json`:
        scenario: Name of the scenario.
        error: Key of `summary["error"]`: the error that doubles.
        variants: By name and disturbance: `doubles` and `lost`, each with the last value before
            and the first at which the error has doubled or the flight was not completed; null
            if there is none. `flown` lists all flights by increasing disturbance: value, error in
            m, and exit reason. `error_m` is the error without a disturbance.

    Args:
        margins: As from `find_margins`.
        scenario: Scenario of the variants.
        folder: An existing folder.
    """
    variants = {
        name: {
            "error_m": margins.outcomes(name)[0].error_m,
            **{label: _search_mapping(search) for label, search in searches.items()},
        }
        for name, searches in margins.searches.items()
    }
    data = {"scenario": scenario.name, "error": margins.key, "variants": variants}
    (folder / "margins.json").write_text(to_json(data), encoding="utf-8")


def _search_mapping(search: Search) -> dict[str, Any]:
    ends = ("last_before", "first_crossed")
    return {
        "doubles": dict(zip(ends, search.doubles, strict=True)),
        "lost": dict(zip(ends, search.lost, strict=True)),
        "flown": [
            [search.values[i], outcome.error_m, outcome.exit_reason]
            for i, outcome in sorted(search.outcomes.items())
        ],
    }


def margins_rows(margins: Margins) -> list[list[str]]:
    """Returns one row per variant: name, error, both margins of each of `COLUMNS`, and a remark."""
    rows = []
    for name, searches in margins.searches.items():
        undisturbed, *others = margins.outcomes(name)
        cells = ["" if undisturbed.error_m is None else millimetres(undisturbed.error_m)]
        for label, (_, factor) in COLUMNS.items():
            search = searches[label]
            cells += [_cell(search, bracket, factor) for bracket in (search.doubles, search.lost)]
        failed = [outcome for outcome in others if outcome.exit_reason == "failed"]
        remark = ""
        if undisturbed.is_lost:
            remark = f"{undisturbed.exit_reason}: {undisturbed.exit_cause}"
        elif failed:
            count = "1 flight" if len(failed) == 1 else f"{len(failed)} flights"
            remark = f"{count} failed: {failed[0].exit_cause}"
        rows.append([name, *cells, remark])
    return rows


def margins_table(margins: Margins) -> str:
    """Returns the table of the disturbances that each variant tolerates, as text."""
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


def _cell(search: Search, bracket: Bracket, factor: float) -> str:
    before, crossed = bracket
    if before is None:
        return ""
    side = "" if crossed is not None else "< " if before < search.values[0] else "> "
    return f"{side}{factor * before:.4g}"


def plot_margins(margins: Margins, title: str, path: Path) -> None:
    """Writes the figure: error against each disturbance.

    A ring marks the last value before the error doubles, a cross at the top the first value at
    which the flight is not completed.

    Args:
        margins: As from `find_margins`.
        title: Plain text.
        path: PNG file to write.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(14, 5.5), dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        draw_margins(figure.subplots(1, len(PANELS), sharey=True, squeeze=False)[0], margins)
        figure.legend(loc="outside lower center", ncols=len(margins.searches))
        write_png(figure, path)


def draw_margins(row: Sequence[Axes], margins: Margins) -> None:
    """Draws the error against the disturbances of each of `PANELS`, in the axes of `row`.

    The first axes have the entries of a legend.
    """
    for axes, (title, disturbances) in zip(row, PANELS.items(), strict=True):
        axes.set_xlabel(title)
        axes.set_yscale("log")
        for name, searches in margins.searches.items():
            for label in disturbances:
                _draw(axes, searches[label], COLUMNS[label][1], COLORS[name])
        if len(disturbances) > 1:  # Factors, which have a logarithmic scale with 1 marked.
            axes.set_xscale("log")
            axes.set_xticks([0.1, 0.2, 0.5, 1, 2, 5], ["0.1", "0.2", "0.5", "1", "2", "5"])
            axes.minorticks_off()
            axes.axvline(1.0, **REFERENCE)
    row[0].set_ylabel("end-effector error / mm")
    for name in margins.searches:
        row[0].plot([], [], color=COLORS[name], label=name)


def _draw(axes: Axes, search: Search, factor: float, color: str) -> None:
    errors = {
        factor * search.values[i]: 1e3 * min(max(outcome.error_m, LEAST_ERROR_M), LARGEST)
        for i, outcome in sorted(search.outcomes.items())
        if not outcome.is_lost and outcome.error_m is not None
    }
    axes.plot(list(errors), list(errors.values()), color=color, marker=".", markersize=4)
    before, crossed = search.doubles
    if before is not None and crossed is not None:
        ring = {"marker": "o", "markersize": 8, "markerfacecolor": "none"}
        axes.plot(factor * before, errors[factor * before], color=color, **ring)
    lost = search.lost[1]
    if lost is not None:
        top = axes.get_xaxis_transform()
        axes.plot(factor * lost, 0.98, "x", color=color, transform=top, markersize=7)
