"""The figure of a flight, `tracking.png`."""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.events import spans
from aerodrake.flight.log import FlightLog
from aerodrake.reports.drawable import drawable
from aerodrake.reports.figures import INK, STYLE, cover, write_png
from aerodrake.reports.flight_panels import (
    draw_allocation,
    draw_angle,
    draw_axis,
    draw_base,
    draw_error,
    draw_paths,
    draw_series,
    draw_spans,
    draw_weights,
    shade_safe_modes,
)
from aerodrake.scenario import Scenario

MOST_SAMPLES = 6000
"""Largest number of samples in a line: ten for each pixel, and all of a minute."""


def plot_tracking(log: FlightLog, scenario: Scenario, title: str, path: Path) -> None:
    """Writes the figure of one flight: paths, errors, allocation, base and joints.

    A flight with orientation task has a panel of the pointing error; one with faults or conditions
    of the supervisor has a panel of these.
    """
    time_spans = spans(scenario, log)
    log = drawable(log).thinned(MOST_SAMPLES)
    with rc_context(STYLE):
        has_angle = log.tool_angle_rad is not None
        rows = 6 + has_angle + bool(time_spans)
        bars = 0.3 + 0.12 * len({(span.mode is None, span.name) for span in time_spans})
        height = 14 / 6 * (rows - bool(time_spans) + bars * bool(time_spans))
        figure = Figure(figsize=(13, height), dpi=120, layout="constrained")
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        heights = [1.0] * (rows - bool(time_spans)) + [bars] * bool(time_spans)
        grid = figure.add_gridspec(rows, 2, width_ratios=[1.15, 1], height_ratios=heights)
        # A column at the right is for the labels of z, which no layout engine regards.
        space = grid[:3, 0].subgridspec(1, 2, width_ratios=[1, 0.08])
        draw_paths(figure.add_subplot(space[0], projection="3d"), log)
        times: list[Axes] = []

        def timeline(cell: Any) -> Axes:
            axes = figure.add_subplot(cell, sharex=times[0] if times else None)
            cover(axes, log.time_s)
            times.append(axes)
            return axes

        for axis, name in enumerate("xyz"):
            draw_axis(timeline(grid[axis, 1]), log, axis, name)
        draw_error(timeline(grid[3, 0]), log)
        draw_allocation(timeline(grid[4, 0]), log)
        draw_weights(timeline(grid[5, 0]), log)
        draw_base(timeline(grid[3, 1]), log)
        draw_series(timeline(grid[4, 1]), log, "q_rad", np.degrees, "joint angles / deg")
        draw_series(timeline(grid[5, 1]), log, "qdot_rad_s", np.degrees, "joint velocities / deg/s")
        if has_angle:
            draw_angle(timeline(grid[6, :]), log)
        if time_spans:
            draw_spans(timeline(grid[-1, :]), time_spans)
        for axes in times:
            shade_safe_modes(axes, log)
        for axes in (times[5], times[-1]):
            axes.set_xlabel("reference time / s")
        write_png(figure, path)
