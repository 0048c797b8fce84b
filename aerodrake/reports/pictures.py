"""Pictures of a page: small figures of one subject each, which also fit on a phone."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.log import FlightLog
from aerodrake.reports.figures import PAGE_STYLE, cover, to_svg
from aerodrake.reports.flight_panels import shade_safe_modes

WIDTH = 5.2
"""Width of a picture in inches; on a phone its text is as large as that of the page."""
ROW = 1.35
"""Height of a panel of a timeline in inches."""
LEFT, RIGHT, TOP, BOTTOM = 0.95, 0.2, 0.36, 0.48
"""Margins for labels in inches. A layout engine would double the time of drawing."""
GAP = 0.4

MOST_SAMPLES = 1200
"""Largest number of samples in a line: three for each point of a picture's width."""

Draw = Callable[[Axes, FlightLog], None]


class Picture(NamedTuple):
    """A figure of a page.

    Attributes:
        title: Heading.
        caption: Description, also for screen readers.
        svg: SVG element, not escaped.
    """

    title: str
    caption: str
    svg: str


@contextmanager
def sheet(
    name: str, height: float, left: float = LEFT, top: float = TOP
) -> Iterator[tuple[Figure, list[str]]]:
    """Yields an empty figure and a list; appends the SVG element to the list at the end.

    Args:
        name: A unique word in the page.
        height: Height in inches.
        left, top: Margins for labels in inches.
    """
    with rc_context(PAGE_STYLE):
        figure = Figure(figsize=(WIDTH, height))
        figure.subplots_adjust(
            left=left / WIDTH,
            right=1 - RIGHT / WIDTH,
            bottom=BOTTOM / height,
            top=1 - top / height,
            hspace=GAP / ROW,
        )
        done: list[str] = []
        yield figure, done
        done.append(to_svg(figure, name))


def timeline(name: str, title: str, caption: str, log: FlightLog, *draws: Draw) -> Picture:
    """Makes panels over reference time, one below the other, with safe modes shaded.

    Args:
        name: A unique word in the page.
        title, caption: See `Picture`.
        log: The log to draw.
        draws: Functions that draw the panels.
    """
    height = TOP + BOTTOM + ROW * len(draws) + GAP * (len(draws) - 1)
    with sheet(name, height) as (figure, done):
        panels = figure.subplots(len(draws), 1, sharex=True, squeeze=False)[:, 0]
        for axes, draw in zip(panels, draws, strict=True):
            cover(axes, log.time_s)
            draw(axes, log)
            shade_safe_modes(axes, log)
        panels[-1].set_xlabel("reference time / s")
        figure.align_ylabels()
    return Picture(title, caption, done[0])
