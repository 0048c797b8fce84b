"""`report.html` of a flight."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.reports.flight_pictures import flight_pictures
from aerodrake.reports.flight_table import highlights, table_rows
from aerodrake.reports.page import render

MOST_EVENTS = 200
"""In a page; a flight can have any number."""


def report_page(
    flight: FlightSimulation,
    summary: dict[str, Any],
    log: FlightLog,
    replay: str,
    folder: Path,
    target: Path,
) -> str:
    """The page of one flight.

    Args:
        flight: As it was flown.
        summary, log: What came of it.
        replay: As from `replay_page`.
        folder: Where `scenario.yaml` is.
        target: Where it is going to be: what repeats the flight is to find it there.
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
        pictures=flight_pictures(log, scenario),
        resolved=(folder / "scenario.yaml").read_text(encoding="utf-8"),
        commands=[shlex.join(["aerodrake", "run", str(target / "scenario.yaml")])],
    )
