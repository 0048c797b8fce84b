"""Figures as parts of a page."""

import re

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.figure import Figure

from aerodrake.reports.figures import PAGE_STYLE, to_svg, write_png

TICKS = ["0.0025", "1.23456789", "<b>&"]


def draw(name: str, samples: int = 50) -> str:
    with rc_context(PAGE_STYLE):
        figure = Figure(figsize=(3, 2))
        axes = figure.add_subplot()
        x = np.linspace(0, 1, samples)
        axes.plot(x, np.sin(3 * x))
        axes.set_yticks([0.2, 0.5, 0.8], TICKS)
        return to_svg(figure, name)


def test_it_is_an_element_that_fills_the_width_of_its_parent():
    svg = draw("a")
    assert svg.startswith("<svg") and svg.rstrip().endswith("</svg>")
    tag = svg[: svg.index(">")]
    assert "viewBox" in tag and "width" not in tag and "height" not in tag
    assert "<style" not in svg


def test_text_stays_text():
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", draw("a"))
    for tick in ("0.0025", "1.23456789", "&lt;b&gt;&amp;"):
        assert tick in texts


@pytest.mark.filterwarnings("error")
def test_names_may_be_of_any_script(tmp_path):
    """The font lacks these glyphs; a browser may have them."""
    name = "悬停 مرحبا 🚁"
    figure = Figure()
    figure.suptitle(name, parse_math=False)
    with rc_context(PAGE_STYLE):
        assert name in to_svg(figure, "a")
    figure = Figure(layout="constrained")
    figure.suptitle(name, parse_math=False)
    write_png(figure, tmp_path / "a.png")


def test_coordinates_are_to_a_hundredth():
    for path in re.findall(r' d="([^"]*)"', draw("a")):
        assert not re.search(r"\.\d{3}", path)


def test_two_on_a_page_share_no_ids():
    ids = [re.findall(r'\bid="([^"]+)"', draw(name)) for name in ("a", "b")]
    assert ids[0] and not set(ids[0]) & set(ids[1])
    assert all(id_.startswith("a-") for id_ in ids[0])
    for reference in re.findall(r'(?:href="#|url\(#)([^")]+)', draw("a")):
        assert reference in ids[0]


def test_the_same_figure_gives_the_same_bytes():
    assert draw("a") == draw("a")
    assert "<metadata" not in draw("a") and "<!DOCTYPE" not in draw("a")


@pytest.mark.parametrize("samples", [2_000, 200_000])
def test_a_smooth_line_takes_few_points(samples):
    assert len(draw("a", samples)) < 15_000
