"""Figure of a comparison, and its panels: paths, distances and errors by variant."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.log import FlightLog
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.reports.drawable import drawable
from aerodrake.reports.figures import (
    ACCENT,
    INK,
    REFERENCE,
    STYLE,
    cover,
    cover_positive,
    write_png,
)
from aerodrake.reports.flight_panels import (
    LEAST_ERROR_MM,
    draw_allocation,
    draw_boundaries,
    draw_distance,
    draw_inputs,
    plot_error,
)
from aerodrake.reports.residual_panels import draw_residual
from aerodrake.scenario import Scenario

COLORS = {
    "integral": "#495057",
    "integral_best": "#adb5bd",
    "modified": "#74c0fc",
    "modified+offline": "#1864ab",
    "modified+online": ACCENT,
    "modified+printed": "#ffc078",
    "clik": "#2b8a3e",
    "fixed_weights": "#9c36b5",
    "no_flight_model": "#5f3dc4",
    "no_tilt": "#f08c00",
    "no_feedforward": "#0c8599",
    "short_horizon": "#c2255c",
    "no_filter": "#862e9c",
    "drake": "#1864ab",
    "mujoco": ACCENT,
}
PANEL_RATIO = 0.85
"""Ratio of height to width of a panel with a path."""

LEGEND_COLUMNS = 7
PANELS = 4
"""Panels in a row, of paths and of distances."""


class View(NamedTuple):
    """Axes and limits of the panels with paths, the same for all variants.

    Attributes:
        axes: Horizontal and vertical world axis.
        low, high: m, limits of each of the two.
    """

    axes: tuple[int, int]
    low: tuple[float, float]
    high: tuple[float, float]

    @classmethod
    def of(cls, logs: Mapping[str, FlightLog]) -> Self:
        """Returns the view along the world axis with the least motion that contains all paths."""
        places = np.vstack([log[key] for log in logs.values() for key in ("p_E_m", "p_Ed_m")])
        places = places[np.isfinite(places).all(axis=1)]
        if not len(places):
            places = np.zeros((1, 3))
        first, second = np.sort(np.argsort(np.ptp(places, axis=0), kind="stable")[1:])
        middle, span = (places.max(axis=0) + places.min(axis=0)) / 2, np.ptp(places, axis=0) + 0.1
        width = max(span[first], span[second] / PANEL_RATIO) / 2
        half = np.array([width, PANEL_RATIO * width])
        middle = middle[[first, second]]
        return cls((int(first), int(second)), tuple(middle - half), tuple(middle + half))


def draw_path(axes: Axes, name: str, log: FlightLog, view: View) -> None:
    """Draws the path of one variant and the reference."""
    first, second = view.axes
    axes.plot(log["p_E_m"][:, first], log["p_E_m"][:, second], color=COLORS[name], linewidth=2)
    axes.plot(log["p_Ed_m"][:, first], log["p_Ed_m"][:, second], **REFERENCE)
    axes.set_title(name, color=COLORS[name], fontsize=10, loc="left")
    axes.set_xlim(view.low[0], view.high[0])
    axes.set_ylim(view.low[1], view.high[1])
    axes.set_aspect("equal", adjustable="box")
    axes.set(xlabel=f"{'xyz'[first]} / m", ylabel=f"{'xyz'[second]} / m")


def draw_distances(axes: Axes, logs: Mapping[str, FlightLog], scenario: Scenario) -> None:
    """Draws d_o, the distance to the centre of the learning space, of each variant."""
    for name, log in logs.items():
        draw_distance(axes, log, COLORS[name])
    draw_boundaries(axes, scenario)
    axes.set_xlabel("reference time / s")
    axes.margins(x=0)


def draw_errors(axes: Axes, logs: Mapping[str, FlightLog], columns: int) -> None:
    """Draws the end-effector error of each variant, with a legend above."""
    for name, log in logs.items():
        plot_error(axes, log, log.error_m, color=COLORS[name], label=name)
    errors = np.concatenate([log.error_m[log.is_flown] for log in logs.values()])
    cover_positive(axes, 1e3 * errors, LEAST_ERROR_MM)
    axes.set(ylabel="end-effector error / mm", xlabel="reference time / s")
    axes.margins(x=0)
    axes.legend(loc="lower center", ncols=columns, bbox_to_anchor=(0.5, 1.0))


def plot_comparison(
    logs: Mapping[str, FlightLog], own: str, scenario: Scenario, title: str, path: Path
) -> None:
    """Writes the figure: paths, errors, residual and its true value, allocation and inputs.

    Args:
        logs: Log of each variant that was flown.
        own: Name of the variant that equals the scenario with the paper's method.
        scenario: Scenario of `own`.
        title: Plain text.
        path: PNG file to write.
    """
    with rc_context(STYLE):
        rows = -(-(len(logs) + 1) // PANELS)
        figure = Figure(figsize=(14, 10 + 3 * rows), dpi=110, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        if logs:
            _draw(figure, rows, {n: drawable(log) for n, log in logs.items()}, own, scenario)
        write_png(figure, path)


def _draw(
    figure: Figure, rows: int, logs: Mapping[str, FlightLog], own: str, scenario: Scenario
) -> None:
    grid = figure.add_gridspec(rows + 3, 12, height_ratios=[1.2] * rows + [1.5, 1, 1.2])
    view = View.of(logs)
    for i, (name, log) in enumerate(logs.items()):
        row, column = divmod(i, PANELS)
        cell = grid[row, 3 * column : 3 * column + 3]
        draw_path(figure.add_subplot(cell), name, log, view)
    distances = figure.add_subplot(grid[rows - 1, 3 * (len(logs) % PANELS) :])
    draw_distances(distances, logs, scenario)
    distances.set_title("d_o, with d_h and d_edge", fontsize=10, loc="left")
    draw_errors(figure.add_subplot(grid[rows, :]), logs, LEGEND_COLUMNS)
    if "modified+online" in logs:
        axes = [figure.add_subplot(grid[rows + 1, 4 * i : 4 * i + 4]) for i in range(3)]
        draw_residual(axes, logs["modified+online"], scenario)
        unit = EquivalentModel.of(scenario, logs["modified+online"].vehicle.joints).residual.unit
        for axis, panel in zip("xyz", axes, strict=True):
            panel.set_title(f"Delta_{axis} of modified+online", fontsize=10, loc="left")
            panel.set(xlabel="reference time / s", ylabel=f"m{unit}" if axis == "x" else "")
    if own in logs:
        axes = [figure.add_subplot(grid[rows + 2, 6 * i : 6 * i + 6]) for i in range(2)]
        draw_allocation(axes[0], logs[own])
        draw_inputs(axes[1], logs[own], scenario)
        for panel, subject in zip(axes, ("weight allocation", "inputs"), strict=True):
            panel.set_title(f"{subject} of {own}", fontsize=10, loc="left")
            panel.set_xlabel("reference time / s")
            cover(panel, logs[own].time_s[logs[own].is_flown])
