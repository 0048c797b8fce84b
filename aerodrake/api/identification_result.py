"""Results of an identification."""

import os
import shlex
from html import escape
from pathlib import Path

from aerodrake.identification.identify import Identification
from aerodrake.identification.report import (
    FIGURE,
    RESULTS,
    draw,
    table,
    write_results,
)
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.support.run_folder import existing_folder, run_folder


class IdentificationResult:
    """Results of an identification. `print` shows its table.

    Attributes:
        identification: Fits and samples of all axes.
    """

    def __init__(self, identification: Identification):
        self.identification = identification

    @property
    def k_b(self) -> tuple[float, ...]:
        """(3,) 1/s, the diagonal of K_B."""
        return self.identification.k_b

    @property
    def scenario(self) -> Scenario:
        """The scenario with the identified K_B."""
        return self.identification.identified_scenario

    @checked
    def save(self, folder: str | os.PathLike[str]) -> Path:
        """Writes `identification.json` and `scenario.yaml`, which has the identified K_B.

        An earlier identification in the folder is replaced as a whole.

        Returns:
            The folder.

        Raises:
            BadInput: if the folder cannot be written, or has other files.
        """
        folder = Path(folder)
        command = shlex.join(["aerodrake", "identify", str(folder / "scenario.yaml")])
        with run_folder(folder, RESULTS) as new:
            write_results(self.identification, command, new)
        return folder

    @checked
    def report(self, folder: str | os.PathLike[str]) -> Path:
        """Writes the figure `identification.png` into a folder, which is created if missing.

        A drawing that fails is logged and left out.

        Returns:
            The path of the figure.

        Raises:
            BadInput: if the folder cannot be written.
        """
        folder = existing_folder(folder)
        draw(self.identification, folder)
        return folder / FIGURE

    def __str__(self) -> str:
        return table(self.identification)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"
