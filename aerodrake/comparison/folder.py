"""Figures and page of a comparison, beside its results."""

from collections.abc import Sequence
from pathlib import Path

from aerodrake.comparison.equal import equal_variants
from aerodrake.comparison.figure import plot_comparison
from aerodrake.comparison.margins_report import plot_margins
from aerodrake.comparison.page import Comparison, comparison_page, distinct_logs
from aerodrake.reports.drawing import drawing
from aerodrake.reports.page import date_of
from aerodrake.support.files import write_atomically

FIGURE, MARGINS_FIGURE, PAGE = "comparison.png", "margins.png", "report.html"


def draw_comparison(
    folder: Path, comparison: Comparison, resolved: str, commands: Sequence[str]
) -> None:
    """Adds `comparison.png`, `margins.png` with margins, and `report.html`.

    Reports if one of them cannot be drawn.

    Args:
        folder: Folder of the results.
        comparison: The comparison to show.
        resolved, commands: See `comparison_page`.
    """
    scenario, own = comparison.scenario, comparison.own
    title = f"{scenario.name}, seed {scenario.seed}"
    equal = equal_variants(comparison.variants)
    title += "".join(f"; {name} equals {first}" for name, first in equal.items())
    path = folder / FIGURE
    with drawing(path):
        shown = comparison.variants.get(own, scenario)
        plot_comparison(distinct_logs(comparison), own, shown, title, path)
    path = folder / MARGINS_FIGURE
    if comparison.margins:
        with drawing(path):
            plot_margins(comparison.margins, title, path)
    path = folder / PAGE
    with drawing(path):
        date = date_of(folder / "comparison.json")
        page = comparison_page(comparison, resolved, commands, date)
        write_atomically(path, page.encode())
