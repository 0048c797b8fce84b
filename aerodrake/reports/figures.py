"""Style of figures, and functions that write them as PNG or as part of a page."""

import io
import re
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter

from aerodrake.support.files import write_atomically

INK, ACCENT = "#1f2933", "#e8590c"
EDGE = "#adb5bd"
REFERENCE: dict[str, Any] = {"color": INK, "linewidth": 0.9, "linestyle": (0, (4, 4))}
AXIS_COLORS = ("#c92a2a", "#2b8a3e", "#1864ab")
STYLE: dict[str, Any] = {
    "axes.edgecolor": EDGE,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9,
    "grid.color": "#e9ecef",
    "legend.frameon": False,
    "lines.linewidth": 1.2,
}
"""Style of all figures, for `rc_context`."""

PAGE_STYLE: dict[str, Any] = STYLE | {
    "axes.facecolor": "none",
    "axes.labelcolor": INK,
    "figure.facecolor": "none",
    "font.size": 10.5,
    "legend.columnspacing": 1.2,
    "legend.handlelength": 1.4,
    "path.simplify_threshold": 0.25,
    "svg.fonttype": "none",
    "svg.hashsalt": "aerodrake",
    "text.color": INK,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
}
"""Style of the figures in pages: with text as text, on a transparent background."""

LEAST_TIME_S = 0.1
"""Shortest span of a time axis."""


def legend_above(axes: Axes, columns: int) -> None:
    """Draws the legend above the panel at the right, where it covers no curve."""
    axes.legend(
        loc="lower right",
        bbox_to_anchor=(1.0, 1.0),
        ncols=columns,
        borderaxespad=0.0,
        borderpad=0.2,
    )


def widen(axis: Axis, span: float) -> None:
    """Extends the limits of an axis to at least `span`, so that rounding errors stay small."""
    low, high = axis.get_view_interval()
    if high - low < span:
        middle = (low + high) / 2
        axis.set_view_interval(middle - span / 2, middle + span / 2, ignore=True)


def cover(axes: Axes, times: np.ndarray) -> None:
    """Sets the limits of a time axis to those of `times` (T,) s, at least `LEAST_TIME_S` apart."""
    start, end = (times[0], times[-1]) if len(times) else (0.0, 0.0)
    axes.set_xlim(start, max(end, start + LEAST_TIME_S))


def cover_positive(axes: Axes, values: np.ndarray, least: float) -> None:
    """Makes the y axis logarithmic, from the least of `values` (K,) to twice the largest.

    Only values from `least`, the level of rounding, on count. Call it after all is drawn.
    """
    shown = values[values >= least]
    low = shown.min() if len(shown) else least
    # Limits first: those of lines without positive values are none of a logarithmic axis.
    high = max(2 * shown.max(initial=low), 10 * low)
    axes.set_ylim(low, high)
    axes.set_yscale("log", nonpositive="mask")
    plain_ticks(axes.yaxis)
    if high <= 10 * low:  # Less than two powers of ten are between the limits.
        axes.yaxis.set_minor_formatter("{x:g}")


def plain_ticks(axis: Axis) -> None:
    """Labels a logarithmic axis with plain numbers instead of powers of ten."""
    axis.set_major_formatter("{x:g}")
    axis.set_minor_formatter(NullFormatter())


def write_png(figure: Figure, path: Path) -> None:
    """Draws a figure into a file, without the second drawing that `savefig` does for its layout.

    The same figure gives the same bytes, without version and date. The file is written atomically.

    Raises:
        BadInput: if the file cannot be written.
    """
    file = io.BytesIO()
    with _any_script():
        FigureCanvasAgg(figure).print_png(file, metadata={"Software": None})
    write_atomically(path, file.getvalue())


def to_svg(figure: Figure, name: str) -> str:
    """Returns a figure as an SVG element that fills the width of its parent.

    Args:
        figure: A figure in `PAGE_STYLE`.
        name: A unique word in the page: prefix of the ids in the element.
    """
    file = io.StringIO()
    with rc_context(PAGE_STYLE), _any_script():
        nothing = dict.fromkeys(("Creator", "Date", "Format", "Type"))
        FigureCanvasSVG(figure).print_svg(file, metadata=nothing)
    text = file.getvalue()
    text = text[text.index("<svg") :]
    text = re.sub(r"<defs>\s*<style.*?</style>\s*</defs>", "", text, count=1, flags=re.S)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text)
    return re.sub(r"<[^>]+>", _rounded, text)


@contextmanager
def _any_script() -> Iterator[None]:
    """Suppresses warnings of glyphs that the font lacks: names may have any script."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from", category=UserWarning)
        yield


def _rounded(tag: re.Match[str]) -> str:
    """Returns a tag with its numbers rounded to two digits, about 0.01 pixels."""
    return re.sub(r"(\.\d\d)\d+", r"\1", tag[0])
