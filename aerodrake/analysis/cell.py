"""Results of an analysis as a cell of a notebook."""

from html import escape

from aerodrake.analysis.analysis import Analysis
from aerodrake.analysis.panels import draw_growth
from aerodrake.analysis.table import MOST_MODES, analysis_table
from aerodrake.reports.pictures import sheet


def analysis_cell(analysis: Analysis) -> str:
    """Returns HTML with the table of an analysis, and growth and frequency of its modes."""
    with sheet("growth", 3.2) as (figure, done):
        draw_growth(figure.add_subplot(), analysis.hover, analysis.hover.least_damped[:MOST_MODES])
    return (
        f"<pre>{escape(analysis_table(analysis))}</pre>"
        f'<figure style="max-width:40em;margin:0">{done[0]}</figure>'
    )
