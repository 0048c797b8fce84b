"""What a person sees of a comparison: the table and the figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight_log import FlightLog
from aerodrake.margin_search import LEAST_ERROR_M
from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.setpoint import SetpointLimits
from aerodrake.model.vehicle import Vehicle
from aerodrake.report import (
    ACCENT,
    AXIS_COLORS,
    INK,
    PAPER,
    REFERENCE,
    STYLE,
    draw_allocation,
    widen,
    write_png,
)
from aerodrake.scenario import Scenario

FILES = ("comparison.json", "comparison.png")
"""What a comparison leaves behind, beside a folder for each variant."""

COLORS = {
    "integral": "#495057",
    "integral_best": "#adb5bd",
    "modified": "#74c0fc",
    "modified+offline": "#1864ab",
    "modified+online": ACCENT,
    "clik": "#2b8a3e",
    "fixed_weights": "#9c36b5",
    "no_flight_model": "#5f3dc4",
    "no_tilt": "#f08c00",
    "no_feedforward": "#0c8599",
    "short_horizon": "#c2255c",
    "no_filter": "#862e9c",
}
HEADLINES = {
    "lap_mean_m": "one lap",
    "settled_mean_m": "after 15 s",
    "mean_m": "mean",
}
"""By key of `summary["error"]`, in the order in which they are preferred."""

WIDTHS = (18, 11, 9, 10, 12, 12, 10, 7, 7)
LEGEND_COLUMNS = 7
PANELS = 4
"""Panels of paths, and the one of distances, in a row."""
PANEL_RATIO = 0.85
"""Height of a path's panel by its width."""

Summaries = Mapping[str, Mapping[str, Any]]


def headline(summaries: Summaries) -> str:
    """The key of `summary["error"]` by which the variants are compared."""
    flown = [s["error"] for s in summaries.values() if "error" in s]
    return next((k for k in HEADLINES if any(e[k] is not None for e in flown)), "mean_m")


def comparison_table(summaries: Summaries, kind: str) -> str:
    """One row for each variant, and the paper's figures below.

    Args:
        summaries: As from `compare`.
        kind: Of the reference.
    """
    key = headline(summaries)
    titles = [
        ("", "error", "error", "error", "first", "prediction", "farthest", "d_o", "joint"),
        ("", HEADLINES[key], "max", "against", "within d_h", "error rms", "d_o", "> d_h", "room"),
        ("variant", "mm", "mm", "integral", "s", "mm/s", "mm", "s", "deg"),
    ]
    integral = summaries.get("integral", {}).get("error", {}).get(key)
    rows = [
        _row(name, summary, key, None if name == "integral" else integral)
        for name, summary in summaries.items()
    ]
    lines = [_line([*title, ""]) for title in titles] + [_line(row) for row in rows]
    return "\n".join([*lines, *_papers_lines(kind, key)])


def _row(name: str, summary: Mapping[str, Any], key: str, integral: float | None) -> list[str]:
    ending = summary["exit_reason"]
    if summary["exit_cause"]:
        ending += f": {summary['exit_cause']}"
    if "error" not in summary:
        return [name, *[""] * (len(WIDTHS) - 1), ending]
    error, arm = summary["error"], summary["arm"]
    rmse = summary["residual"]["prediction_rmse_m_s"]["with_network"]
    change = ""
    if error[key] is not None and integral is not None and integral > LEAST_ERROR_M:
        change = f"{100 * (error[key] / integral - 1):+.1f} %"
    room = arm["least_room_rad"]
    return [
        name,
        _number(error[key], 1e3),
        _number(error["max_m"], 1e3),
        change,
        _number(error["approach_s"]),
        _number(rmse, 1e3),
        _number(arm["farthest_d_o_m"], 1e3, 0),
        _number(arm["outside_s"], 1, 1),
        _number(room, 180 / np.pi, 0),
        ending,
    ]


def _papers_lines(kind: str, key: str) -> list[str]:
    """The paper's figures, where it has flown such a reference."""
    paper = PAPER.get(kind)
    if not paper:
        return []
    rows = [_paper_row("paper: proposed", paper, key)]
    if "integral_lap_mean_m" in paper:
        integral = {"lap_mean_m": paper["integral_lap_mean_m"]}
        rows.insert(0, _paper_row("paper: integral", integral, key))
        rows[1][3] = f"{100 * (paper['lap_mean_m'] / paper['integral_lap_mean_m'] - 1):+.1f} %"
    return ["", *map(_line, rows)]


def _paper_row(name: str, paper: Mapping[str, float], key: str) -> list[str]:
    return [name, _number(paper.get(key), 1e3), "", "", _number(paper.get("approach_s"))]


def _number(value: float | None, factor: float = 1.0, digits: int = 2) -> str:
    return "" if value is None else f"{round(factor * value, digits) + 0.0:.{digits}f}"


def _line(cells: list[str]) -> str:
    text = f"{cells[0]:<{WIDTHS[0]}}"
    text += "".join(f"{c:>{w}}" for c, w in zip(cells[1:], WIDTHS[1:], strict=False))
    return (text + "".join(f"  {ending}" for ending in cells[len(WIDTHS) :])).rstrip()


def plot_comparison(
    logs: Mapping[str, FlightLog], own: str, scenario: Scenario, title: str, path: Path
) -> None:
    """Writes the figure: paths, errors, residual against truth, allocation and inputs.

    Args:
        logs: Of the variants that were flown.
        own: The variant that is the scenario by the paper's method.
        scenario: That of `own`.
        title: Plain text.
        path: A PNG.
    """
    with rc_context(STYLE):
        rows = -(-(len(logs) + 1) // PANELS)
        figure = Figure(figsize=(14, 10 + 3 * rows), dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        if logs:
            _draw(figure, rows, logs, own, scenario)
        write_png(figure, path)


def _draw(
    figure: Figure, rows: int, logs: Mapping[str, FlightLog], own: str, scenario: Scenario
) -> None:
    grid = figure.add_gridspec(rows + 3, 12, height_ratios=[1.2] * rows + [1.5, 1, 1.2])
    cells = [
        grid[i // PANELS, 3 * (i % PANELS) : 3 * (i % PANELS) + 3] for i in range(PANELS * rows)
    ]
    _paths(figure, cells, logs)
    _distances(figure.add_subplot(cells[-1]), logs, scenario)
    _errors(figure.add_subplot(grid[rows, :]), logs)
    if "modified+online" in logs:
        axes = [figure.add_subplot(grid[rows + 1, 4 * i : 4 * i + 4]) for i in range(3)]
        _residual(axes, logs["modified+online"], scenario)
    if own in logs:
        _allocation(figure.add_subplot(grid[rows + 2, :6]), logs[own], own)
        _inputs(figure.add_subplot(grid[rows + 2, 6:]), logs[own], own, scenario)


def _paths(figure: Figure, cells: Sequence[Any], logs: Mapping[str, FlightLog]) -> None:
    """Each variant's path over the reference, seen along the world axis with the least motion."""
    places = np.vstack([log[key] for log in logs.values() for key in ("p_E_m", "p_Ed_m")])
    places = places[np.isfinite(places).all(axis=1)]
    first, second = np.sort(np.argsort(np.ptp(places, axis=0), kind="stable")[1:])
    middle, span = (places.max(axis=0) + places.min(axis=0)) / 2, np.ptp(places, axis=0) + 0.1
    width = max(span[first], span[second] / PANEL_RATIO) / 2
    height = PANEL_RATIO * width
    for cell, (name, log) in zip(cells, logs.items(), strict=False):
        axes = figure.add_subplot(cell)
        axes.plot(log["p_E_m"][:, first], log["p_E_m"][:, second], color=COLORS[name], linewidth=2)
        axes.plot(log["p_Ed_m"][:, first], log["p_Ed_m"][:, second], **REFERENCE)
        axes.set_title(name, color=COLORS[name], fontsize=10, loc="left")
        axes.set_xlim(middle[first] - width, middle[first] + width)
        axes.set_ylim(middle[second] - height, middle[second] + height)
        axes.set_aspect("equal", adjustable="box")
        axes.set(xlabel=f"{'xyz'[first]} / m", ylabel=f"{'xyz'[second]} / m")


def _distances(axes: Axes, logs: Mapping[str, FlightLog], scenario: Scenario) -> None:
    """How far the end-effector is from the centre of its learning space."""
    p_O = Vehicle.load(scenario).p_O
    for name, log in logs.items():
        flown = log.time_s >= 0
        d_o = np.linalg.norm(log.p_EB_m - p_O, axis=1)
        axes.plot(log.time_s[flown], d_o[flown], color=COLORS[name])
    for boundary in ("d_h_m", "d_edge_m"):
        axes.axhline(getattr(scenario.allocation, boundary), **REFERENCE)
    axes.set_title("d_o, with d_h and d_edge", fontsize=10, loc="left")
    axes.set(xlabel="reference time / s", ylabel="m", ylim=(0, None))
    axes.margins(x=0)


def _errors(axes: Axes, logs: Mapping[str, FlightLog]) -> None:
    for name, log in logs.items():
        flown = log.time_s >= 0
        axes.semilogy(log.time_s[flown], 1e3 * log.error_m[flown], color=COLORS[name], label=name)
    errors = np.concatenate([log.error_m[log.time_s > 0] for log in logs.values()])
    errors = errors[np.isfinite(errors)]
    if len(errors):
        low = max(1e3 * np.quantile(errors, 0.02), 1e-3)
        axes.set_ylim(low, max(2e3 * errors.max(), 10 * low))
    axes.set(ylabel="end-effector error / mm", xlabel="reference time / s")
    axes.margins(x=0)
    axes.legend(loc="lower center", ncols=LEGEND_COLUMNS, bbox_to_anchor=(0.5, 1.0))


def _residual(panels: list[Axes], log: FlightLog, scenario: Scenario) -> None:
    times, estimated, true = residuals(log, scenario)
    for axis, axes in enumerate(panels):
        axes.plot(times, 1e3 * true[:, axis], color="#adb5bd", label="true")
        axes.plot(times, 1e3 * estimated[:, axis], color=AXIS_COLORS[axis], label="estimated")
        axes.set_title(f"Delta_{'xyz'[axis]} of modified+online", fontsize=10, loc="left")
        axes.set(xlabel="reference time / s", ylabel="mm/s" if axis == 0 else "")
        axes.margins(x=0, y=0.15)
        widen(axes.yaxis, 1.0)
        axes.legend(loc="upper right", ncols=2)


def residuals(log: FlightLog, scenario: Scenario) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(times (K,) s, estimated (K, 3) m/s, true (K, 3) m/s) of Delta, tick by tick.

    At the tick k the estimator learns how the model's prediction of one period
    fared, with c Delta_{k-1} and without it: the latter's error is what Delta
    should have been, the difference of the two is what it was.
    """
    period = scenario.rates.mpc_period_s
    model = EquivalentModel.of(scenario, log["q_rad"].shape[1])
    gain = model.C[model.base_velocity].diagonal()
    # Logs run several times a tick, and show the tick k from the sample after it on.
    stride = round(period / scenario.rates.flight_period_s)
    ticks = np.arange(3 * stride, len(log.time_s), stride)
    ticks = ticks[log.time_s[ticks] >= 2 * period]
    nominal = log["nominal_prediction_error_m_s"][ticks]
    estimated = (log["prediction_error_m_s"][ticks] - nominal) / gain
    return log.time_s[ticks] - 2 * period, estimated, -nominal / gain


def _allocation(axes: Axes, log: FlightLog, own: str) -> None:
    draw_allocation(axes, log)
    axes.set_title(f"weight allocation of {own}", fontsize=10, loc="left")
    axes.set_xlabel("reference time / s")
    axes.set_xlim(max(log.time_s[0], -1.0), log.time_s[-1])


def _inputs(axes: Axes, log: FlightLog, own: str, scenario: Scenario) -> None:
    """The largest input of base and of joints, each by its own bound."""
    limits = SetpointLimits.make(scenario.mpc, Vehicle.load(scenario)).acceleration
    u = np.abs(np.hstack([log["a_Bd_m_s2"], log["qddot_d_rad_s2"]])) / limits
    for label, columns, color in (
        ("joints", slice(3, None), AXIS_COLORS[1]),
        ("base", slice(3), AXIS_COLORS[2]),
    ):
        axes.plot(log.time_s, u[:, columns].max(axis=1), color=color, label=label)
    axes.axhline(1.0, **REFERENCE)
    axes.set_title(f"largest |u| of {own} by its bound", fontsize=10, loc="left")
    axes.set_xlabel("reference time / s")
    axes.set_ylim(0, 1.1)
    axes.set_xlim(max(log.time_s[0], -1.0), log.time_s[-1])
    axes.legend(loc="best", ncols=2)
