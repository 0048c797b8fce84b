"""Table of the results of a comparison and of the paper."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from aerodrake.comparison.engines import DRAKE, are_engines
from aerodrake.comparison.equal import EQUAL_TO
from aerodrake.comparison.margin_search import LEAST_ERROR_M
from aerodrake.flight.summary import HEADLINES, Summaries, headline, millimetres
from aerodrake.reports.flight_table import PAPER

WIDTHS = (18, 11, 9, 10, 12, 12, 10, 7, 7)


def compared_with(summaries: Summaries) -> str:
    """Returns the variant whose error those of the others are compared with."""
    return DRAKE if are_engines(summaries) else "integral"


def comparison_titles(summaries: Summaries) -> list[tuple[str, str, str]]:
    """Returns a title of three lines, the last a unit, of each column but the exit reason."""
    return [
        ("", "", "variant"),
        ("error", HEADLINES[headline(summaries)], "mm"),
        ("error", "max", "mm"),
        ("error", "against", compared_with(summaries)),
        ("first", "within d_h", "s"),
        ("prediction", "error rms", "mm/s"),
        ("largest", "d_o", "mm"),
        ("d_o", "> d_h", "s"),
        ("joint", "margin", "deg"),
    ]


def comparison_rows(summaries: Summaries) -> list[list[str]]:
    """Returns one row per variant: a cell per title of `comparison_titles`, and the exit reason."""
    key, first = headline(summaries), compared_with(summaries)
    compared = summaries.get(first, {}).get("error", {}).get(key)
    return [
        _row(name, summary, key, None if name == first else compared)
        for name, summary in summaries.items()
    ]


def comparison_table(summaries: Summaries, kind: str) -> str:
    """Returns the table as text; below are the paper's results for `kind` of reference, if any."""
    key = headline(summaries)
    lines = [_line(list(titles)) for titles in zip(*comparison_titles(summaries), strict=True)]
    lines += map(_line, comparison_rows(summaries))
    papers = paper_rows(kind, key)
    return "\n".join([*lines, *[""] * bool(papers), *map(_line, papers)])


def _row(name: str, summary: Mapping[str, Any], key: str, compared: float | None) -> list[str]:
    ending = summary["exit_reason"]
    if summary["exit_cause"]:
        ending += f": {summary['exit_cause']}"
    if EQUAL_TO in summary:
        ending += f", equal to {summary[EQUAL_TO]}"
    if "error" not in summary:
        return [name, *[""] * (len(WIDTHS) - 1), ending]
    error, arm = summary["error"], summary["arm"]
    rmse = summary["residual"]["prediction_rmse_m_s"]["with_network"]
    change = ""
    if error[key] is not None and compared is not None and compared > LEAST_ERROR_M:
        change = f"{100 * (error[key] / compared - 1):+.1f} %"
    return [
        name,
        _length(error[key]),
        _length(error["max_m"]),
        change,
        _number(error["approach_s"]),
        _number(rmse, 1e3),
        _number(arm["farthest_d_o_m"], 1e3, 0),
        _number(arm["outside_s"], 1, 1),
        _number(arm["least_room_rad"], 180 / np.pi, 0),
        ending,
    ]


def paper_rows(kind: str, key: str) -> list[list[str]]:
    """Returns the paper's results for a kind of reference and a key of `error`.

    They have no exit reasons. Rows without a number are left out.
    """
    paper = PAPER.get(kind)
    if not paper:
        return []
    rows = [_paper_row("paper: proposed", paper, key)]
    if key == "lap_mean_m" and "integral_lap_mean_m" in paper:
        integral = {"lap_mean_m": paper["integral_lap_mean_m"]}
        rows.insert(0, _paper_row("paper: integral", integral, key))
        rows[1][3] = f"{100 * (paper['lap_mean_m'] / paper['integral_lap_mean_m'] - 1):+.1f} %"
    return [row for row in rows if any(row[1:])]


def _paper_row(name: str, paper: Mapping[str, float], key: str) -> list[str]:
    return [name, _length(paper.get(key)), "", "", _number(paper.get("approach_s"))]


def _length(value_m: float | None) -> str:
    return "" if value_m is None else millimetres(value_m)


def _number(value: float | None, factor: float = 1.0, digits: int = 2) -> str:
    return "" if value is None else f"{round(factor * value, digits) + 0.0:.{digits}f}"


def _line(cells: list[str]) -> str:
    text = f"{cells[0]:<{WIDTHS[0]}}"
    text += "".join(f"{c:>{w}}" for c, w in zip(cells[1:], WIDTHS[1:], strict=False))
    return (text + "".join(f"  {ending}" for ending in cells[len(WIDTHS) :])).rstrip()
