"""Result of mounting an arm."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

from aerodrake.api.analysis_result import AnalysisResult
from aerodrake.api.flight_result import FlightResult
from aerodrake.flight.summary import millimetres


@dataclass(frozen=True)
class MountResult:
    """Vehicle made for an arm. `print` shows what was changed and chosen, and how it hovers.

    Attributes:
        scenario: Path of the scenario, for `aerodrake.fly`.
        changes: Sentences on changes of the arm's URDF.
        choices: Sentences on what was chosen.
        analysis: Linear analysis of the closed loop.
        hover: A short hover.
    """

    scenario: Path
    changes: tuple[str, ...]
    choices: tuple[str, ...]
    analysis: AnalysisResult
    hover: FlightResult

    @property
    def flies(self) -> bool:
        """True if the closed loop is stable and the hover was completed."""
        return self.analysis.is_stable and self.hover.exit_reason == "completed"

    def __str__(self) -> str:
        error = self.hover.error["mean_m"]
        mean = "" if error is None else f", mean error {millimetres(error)} mm"
        lines = [
            "changed in the arm:",
            *(f"  {sentence}" for sentence in self.changes),
            "chosen:",
            *(f"  {sentence}" for sentence in self.choices),
            f"analysis: {self.analysis.sentence}",
            f"hover: {self.hover.exit_reason}{mean}",
        ]
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<MountResult {self.scenario}: {self.analysis.sentence}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"
