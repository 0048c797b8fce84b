"""Results of one flight."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from pydrake.systems.framework import Diagram

from aerodrake.flight.log import FlightLog
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.reports.flight_folder import PAGE, draw_pages, draw_tracking, write_results
from aerodrake.reports.flight_table import table
from aerodrake.reports.notebook import flight_cell
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import as_yaml, load_scenario
from aerodrake.station import make_closed_loop
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput
from aerodrake.support.files import read_bounded
from aerodrake.support.run_folder import existing_folder, run_folder

MAX_SUMMARY_BYTES = 10_000_000


class FlightResult:
    """Results of one flight. `print` shows its table, a notebook also its errors over time.

    Attributes:
        scenario: The scenario that was flown.
        summary: Content of `summary.json`; `aerodrake.flight.summary.summarize` lists its keys.
        log: Signals over time; `aerodrake.flight.log` lists its arrays with units and shapes.

    Args:
        scenario, summary, log: The attributes.
        make_diagram: Returns the diagram that was flown.
        copies: The scenario with copies of its files as they were during the flight; None if
            they have not changed.
    """

    def __init__(
        self,
        scenario: Scenario,
        summary: Mapping[str, Any],
        log: FlightLog,
        make_diagram: Callable[[], Diagram],
        copies: Scenario | None = None,
    ):
        self.scenario = scenario
        self.summary = summary
        self.log = log
        self._make_diagram = make_diagram
        self._copies = copies or scenario

    @cached_property
    def closed_loop(self) -> Diagram:
        """The diagram that was flown; of a loaded run, the scenario's."""
        return self._make_diagram()

    @property
    def error(self) -> Mapping[str, float | None]:
        """Distance of the end-effector from its reference in m: `mean_m`, `max_m`, ...

        As `error` of the summary. An error whose time span was not flown is None.
        """
        return self.summary["error"]

    @property
    def exit_reason(self) -> str:
        """`completed`, or the reason for which the flight ended earlier, as in the summary."""
        return self.summary["exit_reason"]

    @checked
    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `summary.json`, `log.npz`, `scenario.yaml` and the files that the scenario names.

        An earlier run in the folder is replaced as a whole. `load_run` reads the folder.

        Returns:
            The folder.

        Raises:
            BadInput: if the folder cannot be written, or has other files than an earlier run.
        """
        with run_folder(Path(folder)) as new:
            write_results(new, self._copies, self.summary, self.log)
        return Path(folder)

    @checked
    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `report.html`, and its parts `tracking.png` and `replay.html`, into a folder.

        The folder is created if it is missing. All pages open offline. A drawing that fails is
        logged and left out.

        Returns:
            The path of `report.html`.

        Raises:
            BadInput: if the folder cannot be written.
        """
        folder, scenario = existing_folder(folder), self._copies
        title = f"{scenario.name}, seed {scenario.seed}"
        draw_tracking(folder, scenario, self.log, title)
        resolved = as_yaml(self.scenario)
        draw_pages(folder, scenario, self.summary, self.log, self.closed_loop, resolved)
        return folder / PAGE

    def __str__(self) -> str:
        return table(self.summary, self.scenario.reference.kind)

    def __repr__(self) -> str:
        return f"<FlightResult of {self.scenario.name}: {self.exit_reason}>"

    def _repr_html_(self) -> str:
        return flight_cell(self.scenario, self.summary, self.log)


@checked
def load_run(folder: str | os.PathLike[str]) -> FlightResult:
    """Loads a saved run: a folder of `FlightResult.save`, `aerodrake run` or `aerodrake compare`.

    Raises:
        BadInput: if the folder has no run, or one of its files is damaged.
    """
    folder = Path(folder)
    path = folder / "summary.json"
    content = read_bounded(path, MAX_SUMMARY_BYTES)
    scenario = load_scenario(folder / "scenario.yaml")
    try:
        summary = json.loads(content)
        table(summary, scenario.reference.kind)  # Needs all figures of a flight.
    except (ValueError, KeyError, TypeError, AttributeError, IndexError, RecursionError):
        raise BadInput(path, "", "expected the summary of a flight") from None
    log = FlightLog.read(folder / "log.npz", summary, VehicleModel.load(scenario))
    return FlightResult(scenario, summary, log, lambda: make_closed_loop(scenario))
