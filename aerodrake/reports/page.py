"""Self-contained HTML pages, made from templates."""

import base64
import gzip
import time
from datetime import datetime
from pathlib import Path
from typing import Any

from pydrake.systems.framework import Diagram

from aerodrake.gallery.n2_chart import n2_svg
from aerodrake.support.templates import render_template
from aerodrake.support.version import __version__

CHART_DEPTH = 2
"""Levels of diagrams in the chart: the systems of station and coordinator."""

RECORDERS = ("samples", "log")
"""Systems of a flight beside station and coordinator, which the chart leaves out."""


def render(
    template: str, closed_loop: Diagram, replay: str, *, date: str, poster: str, **content: Any
) -> str:
    """Renders a template and escapes all text.

    Args:
        template: Name of the file in `aerodrake/reports/templates`.
        closed_loop: Diagram for the chart of the page.
        replay: A page from `replay_page`; empty for none.
        date: Date and time of the flight.
        poster: PNG in base64 that is shown where the replay is not; empty for none.
        content: The other variables of the template.
    """
    return render_template(
        "aerodrake.reports",
        template,
        chart=n2_svg(closed_loop, CHART_DEPTH, RECORDERS),
        replay=_packed(replay) if replay else "",
        version=__version__,
        date=date,
        poster=poster,
        **content,
    )


def date_of(results: Path) -> str:
    """Returns the local date and time at which results were written; now if there are none."""
    time_s = results.stat().st_mtime if results.exists() else time.time()
    return datetime.fromtimestamp(time_s).astimezone().strftime("%Y-%m-%d %H:%M %Z")


def _packed(text: str) -> str:
    """Returns compressed text in base64."""
    return base64.b64encode(gzip.compress(text.encode(), compresslevel=6, mtime=0)).decode()
