"""Figure of a comparison."""

from collections.abc import Mapping
from pathlib import Path

from matplotlib import rc_context
from matplotlib.figure import Figure

from aerodrake.comparison.panels import View, draw_distances, draw_errors, draw_path
from aerodrake.flight.log import FlightLog
from aerodrake.reports.figures import INK, STYLE, cover, write_png
from aerodrake.reports.flight_panels import draw_allocation, draw_inputs
from aerodrake.reports.residual_panels import draw_residual
from aerodrake.scenario import Scenario

LEGEND_COLUMNS = 7
PANELS = 4
"""Panels in a row, of paths and of distances."""


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
            _draw(figure, rows, logs, own, scenario)
        write_png(figure, path)


def _draw(
    figure: Figure, rows: int, logs: Mapping[str, FlightLog], own: str, scenario: Scenario
) -> None:
    grid = figure.add_gridspec(rows + 3, 12, height_ratios=[1.2] * rows + [1.5, 1, 1.2])
    cells = [
        grid[i // PANELS, 3 * (i % PANELS) : 3 * (i % PANELS) + 3] for i in range(PANELS * rows)
    ]
    view = View.of(logs)
    for cell, (name, log) in zip(cells, logs.items(), strict=False):
        draw_path(figure.add_subplot(cell), name, log, view)
    distances = figure.add_subplot(cells[-1])
    draw_distances(distances, logs, scenario)
    distances.set_title("d_o, with d_h and d_edge", fontsize=10, loc="left")
    draw_errors(figure.add_subplot(grid[rows, :]), logs, LEGEND_COLUMNS)
    if "modified+online" in logs:
        axes = [figure.add_subplot(grid[rows + 1, 4 * i : 4 * i + 4]) for i in range(3)]
        draw_residual(axes, logs["modified+online"], scenario)
        for axis, panel in zip("xyz", axes, strict=True):
            panel.set_title(f"Delta_{axis} of modified+online", fontsize=10, loc="left")
            panel.set(xlabel="reference time / s", ylabel="mm/s" if axis == "x" else "")
    if own in logs:
        axes = [figure.add_subplot(grid[rows + 2, 6 * i : 6 * i + 6]) for i in range(2)]
        draw_allocation(axes[0], logs[own])
        draw_inputs(axes[1], logs[own], scenario)
        for panel, subject in zip(axes, ("weight allocation", "inputs"), strict=True):
            panel.set_title(f"{subject} of {own}", fontsize=10, loc="left")
            panel.set_xlabel("reference time / s")
            cover(panel, logs[own].time_s[logs[own].is_flown])
