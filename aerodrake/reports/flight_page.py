"""`report.html` of a flight."""

import shlex
from pathlib import Path
from typing import Any

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.reports.flight_table import highlights, notes, table_rows
from aerodrake.reports.page import render

MOST_EVENTS = 200
"""Largest number of events in a page."""


def report_page(
    flight: FlightSimulation,
    summary: dict[str, Any],
    log: FlightLog,
    replay: str,
    folder: Path,
) -> str:
    """Returns the page of one flight.

    Args:
        flight, summary, log: The flight and its results.
        replay: A page from `replay_page`.
        folder: The folder of `scenario.yaml`, also for the command that repeats the flight.
    """
    scenario = flight.scenario
    return render(
        "flight.html",
        flight.closed_loop,
        replay,
        summary=summary,
        highlights=highlights(summary, scenario.reference.kind),
        most_events=MOST_EVENTS,
        rows=table_rows(summary, scenario.reference.kind),
        notes=notes(summary),
        pictures=list(flight_pictures(log, scenario)),
        resolved=(folder / "scenario.yaml").read_text(encoding="utf-8"),
        commands=[shlex.join(["aerodrake", "run", str(folder / "scenario.yaml")])],
    )
