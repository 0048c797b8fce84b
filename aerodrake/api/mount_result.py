"""Result of mounting an arm."""

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from pathlib import Path

from aerodrake.api.analysis_result import AnalysisResult
from aerodrake.api.flight_result import FlightResult
from aerodrake.flight.summary import millimetres

LEAST_DELAY_S = 0.015
"""Delay margin below which a vehicle gets a caution; sensors often have 10 ms of delay."""


@dataclass(frozen=True)
class MountResult:
    """Vehicle made for an arm. `print` shows changes, choices, and the verdicts on its hover.

    Attributes:
        scenario: Path of the scenario, for `aerodrake.fly`.
        changes: Sentences on changes of the arm's URDF.
        choices: Sentences on the choices for the vehicle.
        analysis: Linear analysis of the closed loop.
        push_n: N, force of a push to the base in the hover.
        hover: A short hover, with a push to the base.
    """

    scenario: Path
    changes: tuple[str, ...]
    choices: tuple[str, ...]
    analysis: AnalysisResult
    push_n: float
    hover: FlightResult

    @property
    def flies(self) -> bool:
        """True if the closed loop is stable and the hover was completed."""
        return self.analysis.is_stable and self.hover.exit_reason == "completed"

    def __str__(self) -> str:
        error = self.hover.error["max_m"]
        mm = "" if error is None else millimetres(error)
        moved = f"; a push of {self.push_n:.2g} N moves the tool by {mm} mm" if mm else ""
        lines = [
            "changed in the arm:",
            *(f"  {sentence}" for sentence in self.changes),
            "chosen:",
            *(f"  {sentence}" for sentence in self.choices),
            f"analysis: {self.analysis.sentence}",
            *self._delay_margin(),
            f"hover: {self.hover.exit_reason}{moved}",
        ]
        return "\n".join(lines)

    def _delay_margin(self) -> Iterator[str]:
        margin = self.analysis.margins.get("base_delay")
        if margin is not None and (upper := margin.upper) is not None:
            ms = f"{1000 * upper.value:.3g} ms"
            yield f"delay margin: unstable with {ms} of delay of the base's measurements"
            if upper.value < LEAST_DELAY_S:
                least = f"{1000 * LEAST_DELAY_S:.3g} ms"
                yield f"caution: less than {least}; a heavier and wider base mostly has more"

    def __repr__(self) -> str:
        return f"<MountResult {self.scenario}: {self.analysis.sentence}>"

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"
