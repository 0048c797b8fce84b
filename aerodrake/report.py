"""What a person sees of a flight: the table and the plots."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from aerodrake.events import spans
from aerodrake.flight_log import FlightLog
from aerodrake.model.safe_mode import SafeMode
from aerodrake.model.weight_allocation import Mode
from aerodrake.scenario import Scenario
from aerodrake.supervision_plot import draw_spans, shade_safe_modes

PAPER = {
    "clover": {"lap_mean_m": 0.0122, "integral_lap_mean_m": 0.0302},
    "moving_target": {"settled_mean_m": 0.0197, "approach_s": 5.0},
}
"""The paper's figures, by kind of reference and key of `summary["error"]`.

Keys with `integral_` before them are of its integral model, the others of its method.
"""

MODE_COLORS = {
    Mode.FLIGHT: "#9ecae1",
    Mode.COORDINATED: "#c7e9c0",
    Mode.HOVER: "#f2f0f7",
    Mode.ADJUSTMENT: "#fdd0a2",
}
MOST_SAMPLES = 6000
"""In a line of a figure: ten for each pixel. A minute's log is drawn as it is."""

MOST_EVENTS = 20
"""In a table; a flight can have any number."""

INK, ACCENT = "#1f2933", "#e8590c"
REFERENCE: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 4))}
AXIS_COLORS = ("#c92a2a", "#2b8a3e", "#1864ab")
STYLE: dict[str, Any] = {
    "axes.edgecolor": "#adb5bd",
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9,
    "grid.color": "#e9ecef",
    "legend.frameon": False,
    "lines.linewidth": 1.2,
}
"""Of every figure, for `rc_context`."""


def table(summary: dict[str, Any], kind: str) -> str:
    """The headline figures of one flight, beside the paper's where it has them.

    Args:
        summary: As from `summarize`.
        kind: Of the reference.
    """
    paper, error, angle, base, mpc = (
        PAPER.get(kind, {}),
        *(summary[k] for k in ("error", "orientation", "base_error", "mpc")),
    )
    rows = [("end-effector error", "", "")]
    for key, label in (
        ("lap_mean_m", "mean over one lap"),
        ("settled_mean_m", "mean after 15 s"),
        ("mean_m", "mean"),
        ("rms_m", "rms"),
        ("max_m", "max"),
    ):
        rows.append((f"  {label}", _mm(error[key]), _mm(paper.get(key))))
    approach = _unit(error["approach_s"], "s"), _unit(paper.get("approach_s"), "s")
    rows.append(("  first within d_h", *approach))
    if angle["mean_rad"] is not None:
        rows.append(("tool's angle, mean", _deg(angle["mean_rad"]), ""))
        rows.append(("tool's angle, max", _deg(angle["max_rad"]), ""))
    rows += [
        ("base error, mean", _mm(base["mean_m"]), ""),
        ("base error, max", _mm(base["max_m"]), ""),
        ("MPC tick, median", _unit(mpc["median_ms"], "ms"), ""),
        ("MPC tick, 99 %", _unit(mpc["p99_ms"], "ms"), ""),
        ("MPC fallbacks", f"{mpc['solver_fallbacks']} of {mpc['ticks']}", ""),
    ]
    rows += [
        (f"supervisor in {mode}", _unit(seconds, "s"), "")
        for mode, seconds in summary["safe_modes"].items()
        if seconds and mode != SafeMode.NOMINAL.label
    ]
    rows += [
        (f"time in mode {mode}", _unit(seconds, "s"), "")
        for mode, seconds in summary["modes"].items()
        if seconds
    ]
    rows += [
        ("arm's farthest reach", f"{summary['arm']['farthest_reach_m']:.2f} m", ""),
        ("  d_edge of gamma", f"{summary['arm']['d_edge_m']:.2f} m", "0.38 m"),
    ]
    lines = [
        f"{summary['scenario']}: {summary['exit_reason']}"
        + (f" ({summary['exit_cause']})" if summary["exit_cause"] else ""),
        f"{summary['simulated_s']:.1f} s simulated in {summary['wall_s']:.1f} s, "
        f"{summary['real_time_factor']:.1f} x real time",
        "",
        f"{'':<24}{'here':>12}{'paper':>12}",
        *(f"{label:<24}{here:>12}{there:>12}".rstrip() for label, here, there in rows),
    ]
    lines += [""] * bool(summary["events"])
    lines += [
        f"{event['time_s']:8.2f} s  {event['cause']} {event['event']}"
        + (f": {event['mode']}" if event["event"] == "triggered" else "")
        for event in summary["events"][:MOST_EVENTS]
    ]
    left = len(summary["events"]) - MOST_EVENTS
    if left > 0:
        lines.append(f"{'':11} and {left} more, in summary.json")
    return "\n".join(lines)


def plot_tracking(log: FlightLog, scenario: Scenario, title: str, path: Path) -> None:
    """Writes the figure of one flight: paths, errors, allocation, base and joints.

    And the tool's angle, faults and what the supervisor noticed, where there are some.
    """
    lasting = spans(scenario, log)
    log = log.thinned(MOST_SAMPLES)
    with rc_context(STYLE):
        angle = log.tool_angle_rad
        rows = 6 + (angle is not None) + bool(lasting)
        figure = Figure(figsize=(13, 14 * rows / 6), dpi=120, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        grid = figure.add_gridspec(rows, 2, width_ratios=[1.15, 1])
        _paths(figure.add_subplot(grid[:3, 0], projection="3d"), log)
        times: list[Axes] = []

        def timeline(cell: Any) -> Axes:
            axes = figure.add_subplot(cell, sharex=times[0] if times else None)
            axes.set_xlim(log.time_s[0], log.time_s[-1])
            times.append(axes)
            return axes

        for axis, name in enumerate("xyz"):
            _axis(timeline(grid[axis, 1]), log, axis, name)
        _error(timeline(grid[3, 0]), log)
        draw_allocation(timeline(grid[4, 0]), log)
        _weights(timeline(grid[5, 0]), log)
        _base(timeline(grid[3, 1]), log)
        _series(timeline(grid[4, 1]), log, "q_rad", np.degrees, "joint angles / deg")
        _series(timeline(grid[5, 1]), log, "qdot_rad_s", np.degrees, "joint velocities / deg/s")
        if angle is not None:
            _angle(timeline(grid[6, :]), log.time_s, angle)
        if lasting:
            draw_spans(timeline(grid[-1, :]), lasting)
        for axes in times:
            shade_safe_modes(axes, log)
        for axes in (times[5], times[-1]):
            axes.set_xlabel("reference time / s")
        write_png(figure, path)


def write_png(figure: Figure, path: Path) -> None:
    """Draws a figure into a file, once: `savefig` would do so twice for its layout.

    There is no version or date inside: the same figure gives the same bytes.
    """
    FigureCanvasAgg(figure).print_png(path, metadata={"Software": None})


def _paths(axes: Any, log: FlightLog) -> None:
    flown = log.time_s >= 0
    axes.plot(*log["p_E_m"][flown].T, color=ACCENT, linewidth=2.2, label="end-effector")
    axes.plot(*log["p_Ed_m"][flown].T, **REFERENCE, label="reference")
    axes.plot(*log["p_B_m"][flown].T, color=AXIS_COLORS[2], alpha=0.7, label="base")
    axes.set(xlabel="x / m", ylabel="y / m", zlabel="z / m")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        widen(axis, 0.5)
    axes.set_aspect("equal")
    axes.locator_params(nbins=5)
    axes.legend(loc="upper left")


def _axis(axes: Axes, log: FlightLog, axis: int, name: str) -> None:
    axes.plot(log.time_s, log["p_E_m"][:, axis], color=ACCENT, linewidth=2.2, label="end-effector")
    axes.plot(log.time_s, log["p_Ed_m"][:, axis], **REFERENCE, label="reference")
    widen(axes.yaxis, 0.02)
    axes.set_ylabel(f"{name} / m")
    if axis == 0:
        axes.legend(loc="best", ncols=2)


def _error(axes: Axes, log: FlightLog) -> None:
    flown = log.time_s >= 0
    axes.semilogy(log.time_s[flown], 1e3 * log.error_m[flown], color=ACCENT, label="end-effector")
    axes.semilogy(
        log.time_s[flown],
        1e3 * log.base_error_m[flown],
        color=AXIS_COLORS[2],
        alpha=0.7,
        label="base",
    )
    axes.set_ylim(bottom=max(axes.get_ylim()[0], 1e-2))
    axes.set_ylabel("error / mm")
    axes.legend(loc="best", ncols=2)


def _angle(axes: Axes, time_s: np.ndarray, angle: np.ndarray) -> None:
    axes.plot(time_s, np.degrees(angle), color=ACCENT)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("tool's angle / deg")


def draw_allocation(axes: Axes, log: FlightLog) -> None:
    """gamma, with the modes shaded behind it."""
    mode = log["mode"].astype(int)
    edges = np.flatnonzero(np.diff(mode)) + 1
    for start, end in zip([0, *edges], [*edges, len(mode) - 1], strict=True):
        kind = Mode(mode[start])
        axes.axvspan(log.time_s[start], log.time_s[end], color=MODE_COLORS[kind], linewidth=0)
    for kind in sorted(set(mode)):
        color = MODE_COLORS[Mode(kind)]
        axes.fill_between([], [], facecolor=color, edgecolor=INK, label=Mode(kind).label)
    axes.plot(log.time_s, log["gamma"], color=INK)
    axes.set_ylim(-1.05, 1.05)
    axes.set_ylabel("gamma, mode")
    axes.legend(loc="lower right", ncols=4)


def _weights(axes: Axes, log: FlightLog) -> None:
    for key, color in zip(("w_q", "w_m", "w_d"), AXIS_COLORS, strict=True):
        axes.semilogy(log.time_s, log[key], color=color, label=key)
    axes.set_ylabel("weights")
    axes.legend(loc="best", ncols=3)


def _base(axes: Axes, log: FlightLog) -> None:
    for axis, (name, color) in enumerate(zip("xyz", AXIS_COLORS, strict=True)):
        moved = log["p_B_m"][:, axis] - log["p_B_m"][0, axis]
        axes.plot(log.time_s, moved, color=color, label=name)
    widen(axes.yaxis, 0.01)
    axes.set_ylabel("base moved / m")
    axes.legend(loc="best", ncols=3)


def _series(axes: Axes, log: FlightLog, key: str, convert: Any, label: str) -> None:
    rows = convert(log[key])
    for joint, color in enumerate(colormaps["viridis"](np.linspace(0, 0.9, rows.shape[1]))):
        axes.plot(log.time_s, rows[:, joint], color=color, label=f"q_{joint + 1}")
    widen(axes.yaxis, 1.0)
    axes.set_ylabel(label)
    axes.legend(loc="best", ncols=3)


def widen(axis: Axis, span: float) -> None:
    """Makes an axis show at least `span`, in its unit, lest rounding errors look like motion."""
    low, high = axis.get_view_interval()
    if high - low < span:
        middle = (low + high) / 2
        axis.set_view_interval(middle - span / 2, middle + span / 2, ignore=True)


def _mm(value: float | None) -> str:
    return "" if value is None else f"{1e3 * value:.2f} mm"


def _deg(value: float) -> str:
    return f"{np.degrees(value):.3f} deg"


def _unit(value: float | None, unit: str) -> str:
    return "" if value is None else f"{value:.2f} {unit}"
