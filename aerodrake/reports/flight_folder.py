"""Files of one flight: its results first, then its figure and pages."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydrake.systems.framework import Diagram

from aerodrake.flight.log import FlightLog
from aerodrake.flight.summary import to_json
from aerodrake.reports.drawing import drawing
from aerodrake.reports.flight_figure import plot_tracking
from aerodrake.reports.flight_page import report_page
from aerodrake.reports.replay import replay_page
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import save_scenario
from aerodrake.support.files import write_atomically

RESULTS = ("summary.json", "log.npz", "scenario.yaml")
FIGURE, REPLAY, PAGE = "tracking.png", "replay.html", "report.html"
DRAWINGS = (FIGURE, REPLAY, PAGE)


def write_results(
    folder: Path, scenario: Scenario, summary: Mapping[str, Any], log: FlightLog
) -> None:
    """Writes `RESULTS`, and a copy of each file that the scenario names, into an empty folder.

    Raises:
        OSError: if a file cannot be written.
    """
    (folder / "summary.json").write_text(to_json(summary), encoding="utf-8")
    save_scenario(scenario, folder)
    log.save(folder / "log.npz")


def draw_tracking(folder: Path, scenario: Scenario, log: FlightLog, title: str) -> None:
    """Adds `tracking.png` to an existing folder; logs if that fails."""
    path = folder / FIGURE
    with drawing(path):
        plot_tracking(log, scenario, title, path)


def draw_pages(
    folder: Path,
    scenario: Scenario,
    summary: Mapping[str, Any],
    log: FlightLog,
    closed_loop: Diagram,
    resolved: str,
) -> None:
    """Adds `replay.html` and `report.html` to an existing folder; logs if that fails.

    Args:
        folder: The folder.
        scenario, summary, log, closed_loop, resolved: See `report_page`.
    """
    replay = ""
    with drawing(folder / REPLAY):
        replay = replay_page(log, scenario)
        write_atomically(folder / REPLAY, replay.encode())
    with drawing(folder / PAGE):
        page = report_page(
            *(scenario, summary, log, closed_loop, replay), resolved=resolved, folder=folder
        )
        write_atomically(folder / PAGE, page.encode())
