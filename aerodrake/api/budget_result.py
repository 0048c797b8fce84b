"""Results of an error budget."""

from typing import Any

from aerodrake.api.study_result import StudyResult
from aerodrake.budgets.plan import BudgetPlan
from aerodrake.budgets.report import budget_table, write_budget
from aerodrake.sweeps.folder import SweepFolder


class BudgetResult(StudyResult):
    """Results of an error budget. `print` shows its table, a notebook also its figure.

    Attributes:
        summary: Content of `budget_summary.json`; `aerodrake.budgets.report.summarize_budget` lists
            its keys.
        folder: Folder of the budget.
    """

    files = BudgetPlan.files

    @staticmethod
    def write(folder: SweepFolder) -> dict[str, Any]:
        return write_budget(folder)

    def __str__(self) -> str:
        return budget_table(self.summary)
