"""The pictures of one flight."""

from collections.abc import Iterator
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from aerodrake.flight.events import Span, spans
from aerodrake.flight.log import FlightLog
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.reports.drawable import drawable
from aerodrake.reports.figures import cover
from aerodrake.reports.flight_panels import (
    draw_allocation,
    draw_angle,
    draw_axis,
    draw_base,
    draw_boundaries,
    draw_distance,
    draw_error,
    draw_inputs,
    draw_paths,
    draw_plan,
    draw_series,
    draw_spans,
    draw_thrust,
    draw_ticks,
    draw_weights,
    shade_safe_modes,
)
from aerodrake.reports.pictures import MOST_SAMPLES, Picture, sheet, timeline
from aerodrake.reports.residual_panels import draw_prediction, draw_residual
from aerodrake.scenario import Scenario


def flight_pictures(log: FlightLog, scenario: Scenario) -> Iterator[Picture]:
    """Yields all pictures of a flight in the order of the page; `log` has all samples."""
    log = drawable(log)
    thin = log.thinned(MOST_SAMPLES)
    yield from _motion(thin, scenario)
    caption = "gamma with its modes in the background, and the weights that follow from it."
    panels = (draw_allocation, draw_weights)
    yield timeline("allocation", "Weight allocation", caption, thin, *panels)
    if scenario.residual.mode != "off":
        yield residual_picture(log, thin, scenario)
    caption = (
        "Largest commanded acceleration of base and joints relative to its bound, and thrust of "
        "the rotors with its bounds."
    )
    panels = (partial(draw_inputs, scenario=scenario), partial(draw_thrust, scenario=scenario))
    yield timeline("input", "Inputs", caption, thin, *panels)
    with sheet("ticks", 2.1) as (figure, done):
        draw_ticks(figure.add_subplot(), log, scenario)
    caption = "Wall time of the controller at each tick, and its period."
    yield Picture("Time per tick", caption, *done)
    if time_spans := spans(scenario, log):
        yield _supervision(thin, time_spans)


def residual_picture(log: FlightLog, thin: FlightLog, scenario: Scenario, of: str = "") -> Picture:
    """Returns the picture of Delta and of the prediction error with it and without it.

    Args:
        log: The log with all samples.
        thin: The log with `MOST_SAMPLES` or fewer.
        scenario: The scenario of the flight.
        of: Suffix of the title.
    """
    residual = EquivalentModel.of(scenario, log.vehicle.joints).residual
    with sheet("residual", 7.4) as (figure, done):
        panels = figure.subplots(4, 1, sharex=True)
        draw_residual(panels[:3], log, scenario)
        for name, axes in zip("xyz", panels, strict=False):
            axes.set_ylabel(f"Delta_{name} / m{residual.unit}")
        draw_prediction(panels[3], thin)
        panels[3].set_xlabel("reference time / s")
        cover(panels[3], log.time_s[log.is_flown])
        figure.align_ylabels()
    caption = (
        f"Delta, the {residual.name} of the base: estimated and true. Below, the error of "
        "the base velocity predicted one period ahead, with and without Delta."
    )
    return Picture(f"Residual{of}", caption, *done)


def _motion(log: FlightLog, scenario: Scenario) -> Iterator[Picture]:
    """Yields the pictures of the motion of vehicle and tool."""
    with sheet("path", 4.2) as (figure, done):
        draw_paths(figure.add_axes((0.02, 0.04, 0.9, 0.88), projection="3d"), log)
    yield Picture("Paths", "The end-effector, its reference and the base, in space.", *done)
    with sheet("plan", 4.2) as (figure, done):
        draw_plan(figure.add_subplot(), log)
    yield Picture("Plan", "Paths seen from above.", *done)
    caption = "Distances of the end-effector from its reference and of the base from its setpoint."
    yield timeline("error", "Errors", caption, log, draw_error)
    if log.tool_angle_rad is not None:
        caption = "Angle between the tool's axis and its desired direction."
        yield timeline("angle", "Pointing error", caption, log, draw_angle)
    caption = "The end-effector and its reference along each axis of the world."
    panels = [partial(draw_axis, axis=axis, name=name) for axis, name in enumerate("xyz")]
    yield timeline("position", "Position against reference", caption, log, *panels)
    caption = (
        "Displacement of the base; and d_o, the distance of the end-effector from the centre of "
        "its learning space, with d_h and d_edge."
    )
    panels = [draw_base, partial(_draw_reach, scenario=scenario)]
    yield timeline("base", "Base and reach", caption, log, *panels)
    panels = [
        partial(draw_series, key="q_rad", convert=np.degrees, label="angles / deg"),
        partial(draw_series, key="qdot_rad_s", convert=np.degrees, label="velocities / deg/s"),
    ]
    yield timeline("joints", "Joints", "Angles and velocities of the arm.", log, *panels)


def _draw_reach(axes: Axes, log: FlightLog, scenario: Scenario) -> None:
    draw_distance(axes, log)
    draw_boundaries(axes, scenario)


def _supervision(log: FlightLog, time_spans: list[Span]) -> Picture:
    rows = len({(span.mode is None, span.name) for span in time_spans})
    with sheet("supervision", 1.0 + 0.22 * rows, left=2.1, top=0.36) as (figure, done):
        axes = figure.add_subplot()
        cover(axes, log.time_s)
        draw_spans(axes, time_spans)
        shade_safe_modes(axes, log)
        axes.set_xlabel("reference time / s")
    caption = (
        "Injected faults, and conditions that the supervisor detected, in the colour of the safe "
        "mode that each requests. Times in a safe mode are shaded."
    )
    return Picture("Faults and supervisor", caption, *done)
