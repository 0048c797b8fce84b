"""Files of one flight: its results first, then its figure and pages."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydrake.systems.analysis import Simulator

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize, to_json
from aerodrake.reports.drawing import drawing
from aerodrake.reports.flight_figure import plot_tracking
from aerodrake.reports.flight_page import report_page
from aerodrake.reports.replay import replay_page
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import save_scenario
from aerodrake.support.files import write_atomically


def fly_into(
    folder: Path,
    flight: FlightSimulation,
    progress: Callable[[float], None] = lambda simulated_s: None,
    rate: float = 0.0,
    attach: Callable[[FlightSimulation, Simulator], None] = lambda flight, simulator: None,
) -> tuple[dict[str, Any], FlightLog]:
    """Flies, and writes `summary.json`, `scenario.yaml` and `log.npz`.

    Returns the summary and the log.

    Args:
        folder: An empty folder.
        flight: The flight, ready to fly.
        progress, rate, attach: See `FlightSimulation.fly`.
    """
    log = flight.fly(progress, rate, attach)
    summary = summarize(flight.scenario, log)
    (folder / "summary.json").write_text(to_json(summary), encoding="utf-8")
    save_scenario(flight.scenario, folder)
    log.save(folder / "log.npz")
    return summary, log


def draw_tracking(folder: Path, scenario: Scenario, log: FlightLog, title: str) -> None:
    """Adds `tracking.png` to the folder of a flight; reports if that fails."""
    path = folder / "tracking.png"
    with drawing(path):
        plot_tracking(log, scenario, title, path)


def draw_pages(
    folder: Path, flight: FlightSimulation, summary: dict[str, Any], log: FlightLog
) -> None:
    """Adds `replay.html` and `report.html` to the folder of a flight; reports if that fails."""
    replay = ""
    path = folder / "replay.html"
    with drawing(path):
        replay = replay_page(log, flight.scenario)
        write_atomically(path, replay.encode())
    path = folder / "report.html"
    with drawing(path):
        write_atomically(path, report_page(flight, summary, log, replay, folder).encode())
