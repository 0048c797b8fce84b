"""Figure and page of an analysis, beside its results."""

from pathlib import Path

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from aerodrake.analysis.analysis import Analysis
from aerodrake.analysis.page import analysis_page
from aerodrake.analysis.panels import draw_eigenvalues, draw_gains, draw_growth, draw_steps
from aerodrake.analysis.results import FILE, MATRICES
from aerodrake.analysis.table import MOST_MODES
from aerodrake.reports.drawing import drawing
from aerodrake.reports.figures import INK, STYLE, write_png
from aerodrake.reports.page import date_of
from aerodrake.scenario import Scenario
from aerodrake.support.files import write_atomically

RESULTS = (FILE, MATRICES, "scenario.yaml")
"""Files that every analysis has, also if it could not be drawn."""

FIGURE, PAGE = "analysis.png", "report.html"
DRAWINGS = (FIGURE, PAGE)


def draw_analysis(
    folder: Path, analysis: Analysis, scenario: Scenario, resolved: str, command: str
) -> None:
    """Adds `analysis.png` and `report.html` to an existing folder; logs if one of them fails.

    Args:
        folder: Folder of the results.
        analysis, scenario, resolved, command: See `analysis_page`.
    """
    path = folder / FIGURE
    with drawing(path):
        plot_analysis(analysis, path)
    path = folder / PAGE
    with drawing(path):
        date = date_of(folder / FILE)
        page = analysis_page(analysis, scenario, resolved, command, date)
        write_atomically(path, page.encode())


def plot_analysis(analysis: Analysis, path: Path) -> None:
    """Writes the figure: eigenvalues, growth and frequency, and the responses of a stable loop.

    Args:
        analysis: The analysis to show.
        path: PNG file to write.
    """
    modes = analysis.hover.least_damped[:MOST_MODES]
    with rc_context(STYLE):
        rows = 2 if analysis.hover.is_stable else 1
        figure = Figure(figsize=(13, 4.25 * rows), dpi=110, layout="constrained")
        title = f"{analysis.scenario}: {analysis.sentence}"
        figure.suptitle(title, fontsize=13, color=INK, parse_math=False)
        panels = figure.subplots(rows, 2, squeeze=False)
        eigenvalues, growth = panels[0]
        draw_eigenvalues(eigenvalues, analysis.hover, modes)
        draw_growth(growth, analysis.hover, modes)
        if analysis.hover.is_stable:
            _draw_responses(*panels[1], analysis)
        write_png(figure, path)


def _draw_responses(steps: Axes, gains: Axes, analysis: Analysis) -> None:
    forces = [r for r in analysis.step_responses if r.input.startswith("force")]
    draw_steps(steps, forces)
    steps.set_xlabel("time since a step of the force / s")
    draw_gains(gains, analysis.frequency_responses)
    gains.set_xlabel("frequency / Hz")
