"""Results of a sweep."""

from typing import Any

from aerodrake.api.study_result import StudyResult
from aerodrake.sweeps.folder import SweepFolder, read_rows
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.report import sweep_table, write_report


class SweepResult(StudyResult):
    """Results of a sweep. `print` shows its table, a notebook also its figure.

    Attributes:
        summary: Content of `sweep_summary.json`; `aerodrake.sweeps.report.summarize_sweep` lists
            its keys.
        folder: Folder of the sweep.
    """

    files = Plan.files

    @property
    def rows(self) -> list[dict[str, Any]]:
        """Row of each trial, in their order, with `parameters`, `error`, `exit_reason`, ..."""
        return sorted(read_rows(self.folder), key=lambda row: row["trial"])

    @staticmethod
    def write(folder: SweepFolder) -> dict[str, Any]:
        return write_report(folder)

    def __str__(self) -> str:
        return sweep_table(self.summary)
