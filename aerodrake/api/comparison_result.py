"""Results of a comparison."""

import os
import shlex
import shutil
from functools import cached_property
from html import escape
from pathlib import Path

from aerodrake.api.flight_result import FlightResult, load_run
from aerodrake.comparison.compare import result_notes
from aerodrake.comparison.engines import (
    Differences,
    are_engines,
    difference_table,
    engine_differences,
)
from aerodrake.comparison.folder import PAGE, draw_comparison
from aerodrake.comparison.margins import Margins
from aerodrake.comparison.margins_report import margins_table, write_margins
from aerodrake.comparison.page import Comparison
from aerodrake.comparison.table import comparison_table
from aerodrake.flight.summary import Summaries, to_json
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import as_yaml, save_scenario
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput, nearest
from aerodrake.support.run_folder import existing_folder, run_folder

RESULTS = ("comparison.json", "scenario.yaml")


class ComparisonResult:
    """Results of a comparison. `print` shows its table.

    Args:
        comparison: Scenarios and results.
        scenario: The scenario with the paths of the user's own files.
        baseline: Path of the weights of `integral_best`; None for the packaged ones.
        folder: Folder of the flights, with a folder for each variant.
    """

    def __init__(
        self, comparison: Comparison, scenario: Scenario, baseline: Path | None, folder: Path
    ):
        self.comparison = comparison
        self.scenario = scenario
        self._baseline = baseline
        self._folder = folder

    @property
    def summaries(self) -> Summaries:
        """Summary of each variant by name; a failed flight has only its ending."""
        return self.comparison.summaries

    @property
    def margins(self) -> Margins | None:
        """Disturbances up to which each variant flies; None if they were not searched."""
        return self.comparison.margins

    @cached_property
    def differences(self) -> Differences:
        """Differences between the flights in both engines, of `engines=True`; empty otherwise."""
        return engine_differences(self.comparison.logs)

    @property
    def failed(self) -> bool:
        """True if the process of a flight failed; a lost vehicle is a result."""
        margins = self.margins
        lacks_logs = len(self.comparison.logs) < len(self.comparison.variants)
        return lacks_logs or margins is not None and margins.failed

    @checked
    def flight(self, variant: str) -> FlightResult:
        """Returns the results of one variant.

        Raises:
            BadInput: if there is no such variant, or its flight failed.
        """
        if variant not in self.comparison.logs:
            known = nearest(variant, self.comparison.logs)
            raise BadInput("variant", "", f"no flight of '{variant}'; {known}")
        return load_run(self._folder / variant)

    @checked
    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `comparison.json`, `scenario.yaml`, and the folder of a run for each variant.

        With margins also `margins.json`. An earlier comparison in the folder is replaced as a
        whole.

        Returns:
            The folder.

        Raises:
            BadInput: if the folder cannot be written, or has other files.
        """
        flown, name = self.comparison.scenario, self.scenario.name
        with run_folder(Path(folder), RESULTS) as new:
            figures = {"scenario": name, "variants": self.summaries}
            if self.differences:
                figures["differences"] = self.differences
            (new / "comparison.json").write_text(to_json(figures), encoding="utf-8")
            save_scenario(flown, new)
            for variant in self.comparison.logs:
                shutil.copytree(self._folder / variant, new / variant)
            if self.margins:
                write_margins(self.margins, flown, new)
        return Path(folder)

    @checked
    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `report.html` and `comparison.png`, with margins also `margins.png`.

        The folder is created if it is missing. A drawing that fails is logged and left out.

        Returns:
            The path of `report.html`.

        Raises:
            BadInput: if the folder cannot be written.
        """
        folder = existing_folder(folder)
        resolved = as_yaml(self.scenario)
        draw_comparison(folder, self.comparison, resolved, self._commands(folder))
        return folder / PAGE

    def _commands(self, folder: Path) -> list[str]:
        """Returns the command that repeats the comparison, and those of the variants' flights."""
        variants = self.comparison.variants
        named = [f"--variant={name}" for name in variants]
        words = ["--engines"] if are_engines(variants) else named
        words += [f"--baseline={self._baseline}"] if self._baseline else []
        words += ["--margins"] if self.margins else []
        again = ["aerodrake", "compare", str(folder / "scenario.yaml"), *words]
        flights = [
            ["aerodrake", "run", str(folder / name / "scenario.yaml")]
            for name in self.comparison.logs
        ]
        return [shlex.join(command) for command in (again, *flights)]

    def __str__(self) -> str:
        parts = [comparison_table(self.summaries, self.scenario.reference.kind)]
        parts += [f"\n{difference_table(self.differences)}"] if self.differences else []
        parts += [f"note: {note}" for note in result_notes(self.summaries)]
        parts += [f"\n{margins_table(self.margins)}"] if self.margins else []
        return "\n".join(parts)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"
