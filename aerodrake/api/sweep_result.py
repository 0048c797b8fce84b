"""Results of a sweep."""

import base64
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

from aerodrake.sweeps.folder import read_rows
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.report import sweep_table


class SweepResult:
    """Results of a sweep. `print` shows its table, a notebook also its figure.

    Attributes:
        summary: Content of `sweep_summary.json`; `aerodrake.sweeps.report.summarize_sweep` lists
            its keys.
        folder: Folder of the sweep.
    """

    def __init__(self, summary: Mapping[str, Any], folder: Path):
        self.summary = summary
        self.folder = folder

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Row of each trial, in their order, with `parameters`, `error`, `exit_reason`, ..."""
        return sorted(read_rows(self.folder), key=lambda row: row["trial"])

    def __str__(self) -> str:
        return sweep_table(self.summary)

    def _repr_html_(self) -> str:
        figure = self.folder / Plan.files.figure
        if not figure.exists():  # It could not be drawn.
            return f"<pre>{escape(str(self))}</pre>"
        picture = base64.b64encode(figure.read_bytes()).decode()
        image = f'<img alt="Results of the trials" src="data:image/png;base64,{picture}">'
        return f"<pre>{escape(str(self))}</pre>{image}"
