"""Results of a flight as a cell of a notebook."""

from collections.abc import Mapping
from typing import Any

from aerodrake.flight.log import FlightLog
from aerodrake.reports.drawable import drawable
from aerodrake.reports.flight_panels import draw_error
from aerodrake.reports.flight_table import ending, instability, summary_notes, table_rows
from aerodrake.reports.pictures import MOST_SAMPLES, timeline
from aerodrake.scenario import Scenario
from aerodrake.support.templates import render_template


def flight_cell(scenario: Scenario, summary: Mapping[str, Any], log: FlightLog) -> str:
    """Returns HTML with the table of a flight and its errors over time."""
    caption = "Distances of the end-effector from its reference and of the base from its setpoint."
    errors = timeline("error", "Errors", caption, drawable(log).thinned(MOST_SAMPLES), draw_error)
    return render_template(
        "aerodrake.reports",
        "flight_cell.html",
        name=scenario.name,
        ending=ending(summary),
        instability=instability(summary),
        rows=table_rows(summary, scenario.reference.kind),
        notes=summary_notes(summary),
        errors=errors,
    )
