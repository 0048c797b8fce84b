"""`report.html` of an analysis."""

from collections.abc import Iterator, Sequence

from aerodrake.analysis.analysis import Analysis
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.mode_shape import ModeShape
from aerodrake.analysis.panels import (
    draw_eigenvalues,
    draw_gains,
    draw_growth,
    draw_path,
    draw_shape,
    draw_steps,
)
from aerodrake.analysis.table import (
    MOST_MODES,
    highlights,
    margin_rows,
    mode_rows,
    notes,
    path_rows,
)
from aerodrake.reports.page import render
from aerodrake.reports.pictures import BOTTOM, GAP, ROW, TOP, Picture, sheet
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop

MOST_SHARES = 4
"""Largest number of participants in the bar of a mode."""


def analysis_page(
    analysis: Analysis, scenario: Scenario, resolved: str, command: str, date: str = ""
) -> str:
    """Returns the HTML page of one analysis.

    Args:
        analysis: The analysis to show.
        scenario: Its scenario.
        resolved: The scenario as YAML, with the paths of the user's own files.
        command: Command that repeats the analysis.
        date: Date and time of the analysis; empty for none.
    """
    modes = analysis.hover.least_damped[:MOST_MODES]
    return render(
        "analysis.html",
        make_closed_loop(scenario),
        "",
        date=date,
        poster="",
        analysis=analysis,
        highlights=highlights(analysis),
        modes=list(zip(mode_rows(analysis.hover), modes, strict=True)),
        most_shares=MOST_SHARES,
        margins=margin_rows(analysis),
        notes=notes(analysis),
        motions={p.name for mode in modes for p in analysis.hover.motions(mode)},
        path=list(zip(path_rows(analysis), _are_stable(analysis), strict=True)),
        pictures=list(_pictures(analysis, modes)),
        resolved=resolved,
        commands=[command],
    )


def _are_stable(analysis: Analysis) -> list[bool]:
    """Returns True for each of the `path_rows` at which the loop is stable."""
    return [point.is_stable for point in analysis.path if point.least_damped]


def _pictures(analysis: Analysis, modes: Sequence[Eigenmode]) -> Iterator[Picture]:
    yield from _maps(analysis, modes)
    if oscillations := [mode for mode in modes if mode.frequency_hz > 0]:
        yield _shape(analysis, oscillations[0], modes)
    if analysis.hover.is_stable:  # Responses of an unstable loop grow without bound.
        yield from _responses(analysis)
    if len(analysis.path) > 1:
        with sheet("along", _height(2)) as (figure, done):
            draw_path(figure.subplots(2, 1, sharex=True), analysis)
            figure.align_ylabels()
        caption = (
            "Damping ratio and frequency of the least damped mode, linearised about the flight at "
            "each time; a negative ratio is unstable."
        )
        yield Picture("Along the path", caption, *done)


def _maps(analysis: Analysis, modes: Sequence[Eigenmode]) -> Iterator[Picture]:
    """Yields the maps of the eigenvalues."""
    with sheet("eigenvalues", 2.9, left=0.6, top=0.1) as (figure, done):
        draw_eigenvalues(figure.add_subplot(), analysis.hover, modes)
    caption = (
        "Eigenvalues of the sampled loop in hover, and with numbers the modes of the table. The "
        "loop is stable if all are within the unit circle. Thin lines are damping ratios of 0.1, "
        "0.3 and 0.6, and natural frequencies in Hz."
    )
    yield Picture("Eigenvalues", caption, *done)
    with sheet("growth", 3.2) as (figure, done):
        draw_growth(figure.add_subplot(), analysis.hover, modes)
    caption = "The slow modes by growth and frequency; those left of the dashed line decay."
    yield Picture("Growth and frequency", caption, *done)


def _shape(analysis: Analysis, mode: Eigenmode, modes: Sequence[Eigenmode]) -> Picture:
    """Returns the picture of the motion in one mode of the table."""
    with sheet("shape", _height(2)) as (figure, done):
        panels = figure.subplots(2, 1, sharex=True)
        draw_shape(panels, ModeShape.of(analysis.hover.system, mode))
        panels[-1].set_xlabel("phase / deg")
        figure.align_ylabels()
    number = [*modes].index(mode) + 1
    caption = (
        f"Motion in mode {number}, at {mode.frequency_hz:.2f} Hz, over one period: tool and "
        "base above, attitude and joints below, scaled to 1 mm of tool motion."
    )
    return Picture(f"Mode {number}", caption, *done)


def _responses(analysis: Analysis) -> Iterator[Picture]:
    """Yields the pictures of the responses."""
    for kind, name in (("force", "disturbance force"), ("torque", "disturbance torque")):
        steps = [r for r in analysis.step_responses if r.input.startswith(kind)]
        if steps:
            with sheet(f"step-{kind}", 2.4) as (figure, done):
                axes = figure.add_subplot()
                draw_steps(axes, steps)
                axes.set_xlabel("time since the step / s")
            caption = f"Distance of the tool from its place after a step of the base's {name}."
            yield Picture(f"Step of the {kind}", caption, *done)
    for kinds, title, caption in (
        (
            ("force", "torque"),
            "Disturbances over frequency",
            "Largest gain from force and torque on the base to the position of the tool.",
        ),
        (
            ("noise",),
            "Sensor noise over frequency",
            "Largest gain from errors of the samples to the position of the tool.",
        ),
    ):
        gains = [r for r in analysis.frequency_responses if r.input.endswith(kinds)]
        if gains:
            with sheet(kinds[0] + "-gain", 2.9, top=0.6) as (figure, done):
                axes = figure.add_subplot()
                draw_gains(axes, gains)
                axes.set_xlabel("frequency / Hz")
            yield Picture(title, caption, *done)


def _height(panels: int) -> float:
    """Returns the height of a sheet with panels one below the other, in inches."""
    return TOP + BOTTOM + ROW * panels + GAP * (panels - 1)
