"""The pictures of a page: small figures, one for each subject, that stack on a phone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import NamedTuple

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.flight.log import FlightLog
from aerodrake.reports.figures import PAGE_STYLE, cover, to_svg
from aerodrake.reports.supervision_panels import shade_safe_modes

WIDTH = 5.2
"""In inches, of every picture: on a phone its type is as large as the page's."""
ROW = 1.35
"""Height of a panel of a timeline."""
LEFT, RIGHT, TOP, BOTTOM = 0.85, 0.2, 0.1, 0.42
"""Around panels, for their labels: a layout engine would take as long as all else."""
GAP = 0.14

MOST_SAMPLES = 1200
"""In a line: three for each point of a picture's width."""

Draw = Callable[[Axes], None]


class Picture(NamedTuple):
    """A figure of a page.

    Attributes:
        title: Its heading.
        caption: What it shows, for those who cannot see it, too.
        svg: The element, of which nothing is to be escaped.
    """

    title: str
    caption: str
    svg: str


@contextmanager
def sheet(
    name: str, height: float, left: float = LEFT, top: float = TOP
) -> Iterator[tuple[Figure, list[str]]]:
    """Yields an empty figure and a list, which the finished element joins.

    Args:
        name: A word that no other picture of the page has.
        height: In inches.
        left, top: Likewise, what is left for labels there.
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
    """Panels over reference time, one below the other, with safe modes shaded.

    Args:
        name: A word that no other picture of the page has.
        title, caption: As of `Picture`.
        log: Whose times they are.
        draws: What fills each.
    """
    height = TOP + BOTTOM + ROW * len(draws) + GAP * (len(draws) - 1)
    with sheet(name, height) as (figure, done):
        panels = figure.subplots(len(draws), 1, sharex=True, squeeze=False)[:, 0]
        for axes, draw in zip(panels, draws, strict=True):
            cover(axes, log.time_s)
            draw(axes)
            shade_safe_modes(axes, log)
        panels[-1].set_xlabel("reference time / s")
        figure.align_ylabels()
    return Picture(title, caption, done[0])
