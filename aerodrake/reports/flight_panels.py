"""Panels of a flight's figures, of one subject each."""

from collections.abc import Iterator, Sequence
from typing import Any, TypeVar

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes

from aerodrake.flight.events import Span
from aerodrake.flight.log import FlightLog
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.reports.figures import (
    ACCENT,
    AXIS_COLORS,
    INK,
    REFERENCE,
    cover_positive,
    legend_above,
    widen,
)
from aerodrake.scenario import Scenario

LEAST_ERROR_MM = 1e-6
"""Smallest error that figures show: level of rounding."""

LEAST_TICK_MS = 1e-3
"""Smallest wall time of a tick that figures show."""

LEAST_WEIGHT = 1e-6
"""Smallest weight that figures show."""

MOST_TICKS = 1500
"""Largest number of ticks in a line of a figure."""

MODE_COLORS = {
    Mode.FLIGHT: "#9ecae1",
    Mode.COORDINATED: "#c7e9c0",
    Mode.HOVER: "#f2f0f7",
    Mode.ADJUSTMENT: "#fdd0a2",
}
SAFE_MODE_COLORS = {
    SafeMode.NOMINAL: "#868e96",
    SafeMode.HOLD: "#ffe066",
    SafeMode.DESCEND: "#ffa94d",
    SafeMode.STOP: "#fa5252",
}
MOST_COLUMNS = 8
"""Largest number of columns of a legend."""

FAULT_COLOR = "#495057"

WEIGHTS = ("w_q", "w_m", "w_d")

M = TypeVar("M", Mode, SafeMode)

PATHS: dict[str, dict[str, Any]] = {
    "p_E_m": {"color": ACCENT, "linewidth": 2.2, "label": "end-effector"},
    "p_Ed_m": {**REFERENCE, "label": "reference"},
    "p_B_m": {"color": AXIS_COLORS[2], "alpha": 0.7, "label": "base"},
}
"""Styles of the paths, by their keys in the log."""


def draw_paths(axes: Any, log: FlightLog) -> None:
    """Draws end-effector, reference and base in three-dimensional `axes`."""
    for key, style in PATHS.items():
        axes.plot(*log[key][log.is_flown].T, **style)
    axes.set(xlabel="x / m", ylabel="y / m", zlabel="z / m")
    for axis in (axes.xaxis, axes.yaxis, axes.zaxis):
        widen(axis, 0.5)
    axes.autoscale(enable=False)  # 3D axes would be scaled again when drawn.
    axes.set_aspect("equal")
    axes.locator_params(nbins=5)
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, borderaxespad=0.0)


def draw_plan(axes: Axes, log: FlightLog) -> None:
    """Draws end-effector, reference and base from above, in world x and y."""
    for key, style in PATHS.items():
        axes.plot(*log[key][log.is_flown].T[:2], **style)
    for axis in (axes.xaxis, axes.yaxis):
        widen(axis, 0.5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="x / m", ylabel="y / m")
    legend_above(axes, 3)


def draw_axis(axes: Axes, log: FlightLog, axis: int, name: str) -> None:
    """Draws the end-effector and its reference along one world axis."""
    for key in ("p_E_m", "p_Ed_m"):
        axes.plot(log.time_s, log[key][:, axis], **PATHS[key])
    widen(axes.yaxis, 0.02)
    axes.set_ylabel(f"{name} / m")
    if axis == 0:
        legend_above(axes, 2)


def plot_error(axes: Axes, log: FlightLog, error_m: np.ndarray, **style: Any) -> None:
    """Draws a distance error_m (T,) m in mm, for a logarithmic axis."""
    error_mm = np.maximum(1e3 * error_m[log.is_flown], LEAST_ERROR_MM)
    axes.plot(log.time_s[log.is_flown], error_mm, **style)


def draw_error(axes: Axes, log: FlightLog) -> None:
    """Draws the distances of end-effector and base from reference and setpoint."""
    plot_error(axes, log, log.error_m, color=ACCENT, label="end-effector")
    plot_error(axes, log, log.base_error_m, **PATHS["p_B_m"])
    errors = np.concatenate([log.error_m[log.is_flown], log.base_error_m[log.is_flown]])
    cover_positive(axes, 1e3 * errors, LEAST_ERROR_MM)
    axes.set_ylabel("error / mm")
    legend_above(axes, 2)


def draw_angle(axes: Axes, log: FlightLog) -> None:
    """Draws the tool's angle to its desired direction, in a flight with the orientation task."""
    axes.plot(log.time_s, np.degrees(log.tool_angle_rad), color=ACCENT)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("pointing error / deg")


def draw_allocation(axes: Axes, log: FlightLog) -> None:
    """Draws gamma, with the modes in the background."""
    stretches = list(_stretches(Mode, log["mode"], log.time_s))
    for kind, start_s, end_s in stretches:
        axes.axvspan(start_s, end_s, color=MODE_COLORS[kind], linewidth=0)
    for kind in sorted({kind for kind, _, _ in stretches}):
        axes.fill_between([], [], facecolor=MODE_COLORS[kind], edgecolor=INK, label=kind.label)
    axes.plot(log.time_s, log["gamma"], color=INK)
    axes.set_ylim(-1.05, 1.05)
    axes.set_ylabel("gamma, mode")
    if stretches:
        legend_above(axes, 4)


def draw_weights(axes: Axes, log: FlightLog) -> None:
    """Draws the weights of the MPC's cost that the allocation sets."""
    for key, color in zip(WEIGHTS, AXIS_COLORS, strict=True):
        axes.plot(log.time_s, log[key], color=color, label=key)
    weights = np.concatenate([log[key] for key in WEIGHTS])  # Zero before the first tick.
    cover_positive(axes, weights, LEAST_WEIGHT)
    axes.set_ylabel("weights")
    legend_above(axes, 3)


def draw_base(axes: Axes, log: FlightLog) -> None:
    """Draws the displacement of the base from its start."""
    for axis, (name, color) in enumerate(zip("xyz", AXIS_COLORS, strict=True)):
        moved = log["p_B_m"][:, axis] - log["p_B_m"][0, axis]
        axes.plot(log.time_s, moved, color=color, label=name)
    widen(axes.yaxis, 0.01)
    axes.set_ylabel("base displacement / m")
    legend_above(axes, 3)


def draw_series(axes: Axes, log: FlightLog, key: str, convert: Any, label: str) -> None:
    """Draws a line for each joint of a key of the log, in the unit of `convert`."""
    _plot_columns(axes, log.time_s, convert(log[key]), "q_")
    widen(axes.yaxis, 1.0)
    axes.set_ylabel(label)
    legend_above(axes, MOST_COLUMNS)


def draw_distance(axes: Axes, log: FlightLog, color: str = ACCENT) -> None:
    """Draws d_o, the distance of the end-effector from the centre of its learning space."""
    flown = log.is_flown
    axes.plot(log.time_s[flown], log.d_o_m[flown], color=color)
    axes.set_ylabel("d_o / m")


def draw_boundaries(axes: Axes, scenario: Scenario) -> None:
    """Draws d_h and d_edge, the limits of d_o; call it after d_o is drawn."""
    for boundary in ("d_h_m", "d_edge_m"):
        axes.axhline(getattr(scenario.allocation, boundary), **REFERENCE)
    axes.set_ylim(bottom=0)


def draw_inputs(axes: Axes, log: FlightLog, scenario: Scenario) -> None:
    """Draws the largest accelerations u of base and joints relative to their bounds."""
    limits = SetpointLimits.make(scenario.mpc, log.vehicle).acceleration
    u = np.abs(np.hstack([log["a_Bd_m_s2"], log["qddot_d_rad_s2"]])) / limits
    axes.plot(log.time_s, u[:, 3:].max(axis=1), color=AXIS_COLORS[1], label="joints")
    axes.plot(log.time_s, u[:, :3].max(axis=1), color=AXIS_COLORS[2], label="base")
    axes.axhline(1.0, **REFERENCE)
    axes.set_ylim(0, 1.1)
    axes.set_ylabel("largest |u| / bound")
    legend_above(axes, 2)


def draw_thrust(axes: Axes, log: FlightLog, scenario: Scenario) -> None:
    """Draws the thrust of each rotor and its bounds."""
    _plot_columns(axes, log.time_s, log["thrust_n"])
    for bound in (scenario.vehicle.rotor.min_thrust_n, scenario.vehicle.rotor.max_thrust_n):
        axes.axhline(bound, **REFERENCE)
    axes.set_ylabel("rotor thrust / N")
    legend_above(axes, MOST_COLUMNS)


def draw_ticks(axes: Axes, log: FlightLog, scenario: Scenario) -> None:
    """Draws the wall time of each tick of the controller, and its period."""
    ticks = log["tick_ms"]
    # The slowest of the ticks that share a point of the line.
    starts = np.arange(0, len(ticks), -(-len(ticks) // MOST_TICKS) or 1)
    slowest = np.maximum.reduceat(ticks, starts) if len(ticks) else ticks
    period_ms = 1e3 * scenario.rates.mpc_period_s
    axes.plot(starts, slowest, color=ACCENT, linewidth=0.8, label="forming and solving")
    axes.axhline(period_ms, **REFERENCE, label="period")
    cover_positive(axes, np.append(slowest, period_ms), LEAST_TICK_MS)
    axes.set(xlabel="tick", ylabel="wall time / ms")
    legend_above(axes, 2)


def shade_safe_modes(axes: Axes, log: FlightLog) -> None:
    """Shades the times in which the supervisor is not in NOMINAL."""
    for mode, start_s, end_s in _stretches(SafeMode, log["supervisor_mode"], log.time_s):
        if mode != SafeMode.NOMINAL:
            color = SAFE_MODE_COLORS[mode]
            axes.axvspan(start_s, end_s, color=color, alpha=0.35, linewidth=0)


def draw_spans(axes: Axes, spans: Sequence[Span]) -> None:
    """Draws a bar for each time span of a fault or condition, one row for each name."""
    rows = list(dict.fromkeys((span.mode is None, span.name) for span in spans))
    for span in spans:
        row = rows.index((span.mode is None, span.name))
        color = FAULT_COLOR if span.mode is None else SAFE_MODE_COLORS[span.mode]
        length = max(span.end_s - span.start_s, 0.02)  # Long enough to be visible.
        axes.barh(row, length, left=span.start_s, height=0.6, color=color, linewidth=0)
    labels = [f"{name} (injected)" if is_fault else name for is_fault, name in rows]
    axes.set_yticks(range(len(rows)), labels)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="y", visible=False)
    for mode in sorted({span.mode for span in spans if span.mode is not None}):
        axes.barh([0], [0], color=SAFE_MODE_COLORS[mode], label=mode.label)
    if axes.get_legend_handles_labels()[0]:
        legend_above(axes, 4)


def _plot_columns(axes: Axes, time_s: np.ndarray, rows: np.ndarray, prefix: str = "") -> None:
    """Plots each column of `rows` (T, width), numbered from 1."""
    for i, color in enumerate(colormaps["viridis"](np.linspace(0, 0.9, rows.shape[1]))):
        axes.plot(time_s, rows[:, i], color=color, label=f"{prefix}{i + 1}")


def _stretches(
    kind: type[M], modes: np.ndarray, time_s: np.ndarray
) -> Iterator[tuple[M, float, float]]:
    """Yields each mode of `modes` (T,) with the start and end in s of its time span.

    Spans in which `modes` are not of that kind, NaN for example, are left out.
    """
    edges = np.flatnonzero(np.diff(modes)) + 1
    for start, end in zip([0, *edges], [*edges, len(modes) - 1], strict=True):
        if modes[start] in [*kind]:
            yield kind(int(modes[start])), time_s[start], time_s[end]
