"""Flies a flight and writes its results into a folder."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from pydrake.systems.analysis import Simulator

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize, to_json
from aerodrake.reports.flight_figure import plot_tracking
from aerodrake.scenario.load import save_scenario


def fly_into(
    folder: Path,
    flight: FlightSimulation,
    title: str,
    progress: Callable[[float], None] = lambda simulated_s: None,
    rate: float = 0.0,
    attach: Callable[[FlightSimulation, Simulator], None] = lambda flight, simulator: None,
) -> tuple[dict[str, Any], FlightLog]:
    """Flies, and writes `summary.json`, `log.npz`, `scenario.yaml` and `tracking.png`.

    Returns the summary and the log.

    Args:
        folder: An empty folder.
        flight: The flight, ready to fly.
        title: Title of the figure.
        progress, rate, attach: See `FlightSimulation.fly`.
    """
    log = flight.fly(progress, rate, attach)
    summary = summarize(flight.scenario, log)
    (folder / "summary.json").write_text(to_json(summary), encoding="utf-8")
    save_scenario(flight.scenario, folder)
    log.save(folder / "log.npz")
    plot_tracking(log, flight.scenario, title, folder / "tracking.png")
    return summary, log
