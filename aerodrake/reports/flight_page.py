"""`report.html` of a flight."""

import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydrake.systems.framework import Diagram

from aerodrake.flight.log import FlightLog
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.reports.flight_table import highlights, instability, summary_notes, table_rows
from aerodrake.reports.page import date_of, render
from aerodrake.reports.poster import poster
from aerodrake.scenario import Scenario

MOST_EVENTS = 200
"""Largest number of events in a page."""


def report_page(
    scenario: Scenario,
    summary: Mapping[str, Any],
    log: FlightLog,
    closed_loop: Diagram,
    replay: str,
    *,
    resolved: str,
    folder: Path,
) -> str:
    """Returns the page of one flight.

    Args:
        scenario, summary, log: The flight's.
        closed_loop: Diagram that was flown.
        replay: A page from `replay_page`.
        resolved: The scenario as YAML, with the paths of the user's own files.
        folder: Folder of the results, for their date and the command that repeats the flight.
    """
    kind = scenario.reference.kind
    return render(
        "flight.html",
        closed_loop,
        replay,
        date=date_of(folder / "summary.json"),
        poster=poster(log, scenario),
        summary=summary,
        instability=instability(summary),
        highlights=highlights(summary, kind),
        most_events=MOST_EVENTS,
        rows=table_rows(summary, kind),
        notes=summary_notes(summary),
        pictures=list(flight_pictures(log, scenario)),
        resolved=resolved,
        commands=[shlex.join(["aerodrake", "run", str(folder / "scenario.yaml")])],
    )
