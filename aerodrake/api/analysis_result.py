"""Results of an analysis of the closed loop."""

import os
import shlex
from pathlib import Path

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.cell import analysis_cell
from aerodrake.analysis.eigenmode import Eigenmode
from aerodrake.analysis.folder import PAGE, RESULTS, draw_analysis
from aerodrake.analysis.margins import StabilityMargin
from aerodrake.analysis.responses import FrequencyResponse, StepResponse
from aerodrake.analysis.results import write_results
from aerodrake.analysis.sampled_system import SampledSystem
from aerodrake.analysis.table import analysis_table
from aerodrake.scenario import Scenario
from aerodrake.scenario.load import as_yaml, save_scenario
from aerodrake.support.arguments import checked
from aerodrake.support.run_folder import existing_folder, run_folder


class AnalysisResult:
    """Results of an analysis. `print` shows its table, a notebook also a figure of its modes.

    Attributes:
        analysis: All results.
        scenario: The scenario that was analysed.

    Args:
        analysis, scenario: The attributes.
        copies: The scenario with copies of its files as they were during the analysis; None if
            they have not changed.
    """

    def __init__(self, analysis: Analysis, scenario: Scenario, copies: Scenario | None = None):
        self.analysis = analysis
        self.scenario = scenario
        self._copies = copies or scenario

    @property
    def is_stable(self) -> bool:
        """True if the loop is stable in hover and at all requested times."""
        return self.analysis.is_stable

    @property
    def sentence(self) -> str:
        """Verdict in one line, with motions, frequency and growth of the least stable mode."""
        return self.analysis.sentence

    @property
    def system(self) -> SampledSystem:
        """The linear system in hover; `system.state_space` is for `scipy.signal`."""
        return self.analysis.hover.system

    @property
    def modes(self) -> tuple[Eigenmode, ...]:
        """Modes in hover, the fastest growing first."""
        return self.analysis.hover.modes

    @property
    def margins(self) -> dict[str, StabilityMargin]:
        """Margins in hover: `base_delay`, `rotor_gain` and `joint_gain`."""
        return {margin.name: margin for margin in self.analysis.margins}

    @property
    def step_responses(self) -> dict[str, StepResponse]:
        """Motion of the tool after a step of `force_x`, ..., `torque_z`, by these names."""
        return {response.input: response for response in self.analysis.step_responses}

    @property
    def frequency_responses(self) -> dict[str, FrequencyResponse]:
        """Gains from disturbances and sensor noise to the tool, by the name of the input."""
        return {response.input: response for response in self.analysis.frequency_responses}

    @property
    def path(self) -> tuple[OperatingPoint, ...]:
        """The loop at each requested time, in order."""
        return self.analysis.path

    @checked
    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `analysis.json`, `system.npz`, `scenario.yaml` and the scenario's files.

        An earlier analysis in the folder is replaced as a whole.

        Returns:
            The folder.

        Raises:
            BadInput: if the folder cannot be written, or has other files.
        """
        with run_folder(Path(folder), RESULTS) as new:
            write_results(self.analysis, self._copies, new)
            save_scenario(self._copies, new)
        return Path(folder)

    @checked
    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `report.html` and `analysis.png` into a folder, which is created if missing.

        The page opens offline. A drawing that fails is logged and left out.

        Returns:
            The path of `report.html`.

        Raises:
            BadInput: if the folder cannot be written.
        """
        folder = existing_folder(folder)
        resolved = as_yaml(self.scenario)
        times = [f"{point.time_s:.10g}" for point in self.path]
        again = ["aerodrake", "analyze", str(folder / "scenario.yaml")]
        again += ["--at", *times] if times else []
        draw_analysis(folder, self.analysis, self._copies, resolved, shlex.join(again))
        return folder / PAGE

    def __str__(self) -> str:
        return analysis_table(self.analysis)

    def __repr__(self) -> str:
        return f"<AnalysisResult of {self.scenario.name}: {self.sentence}>"

    def _repr_html_(self) -> str:
        return analysis_cell(self.analysis)
