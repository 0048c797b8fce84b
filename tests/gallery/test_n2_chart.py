"""The N-squared chart: complete, without overlaps, and text within its boxes."""

import re
from itertools import combinations
from xml.etree import ElementTree

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain

from aerodrake.gallery.graph import graph_of, systems_by_name
from aerodrake.gallery.n2_chart import n2_chart, n2_svg
from aerodrake.scenario import RotorDegraded, SampleNan, Scenario
from aerodrake.scenario.load import load_scenario
from aerodrake.station import make_closed_loop
from tests.browser import chromium

LOOPS = {
    "default": make_closed_loop(Scenario()),
    "clik": make_closed_loop(Scenario(controller="clik")),
    "faults": make_closed_loop(
        Scenario(faults=(RotorDegraded(1.0, 1.0, rotor=0, remaining=0.5), SampleNan(1.0, 1.0)))
    ),
    "realistic": make_closed_loop(load_scenario("clover_realistic")),
    "pointing": make_closed_loop(load_scenario("clover_pointing")),
}
DRAWN = {
    **{name: (loop, 2) for name, loop in LOOPS.items()},
    "shallow": (LOOPS["default"], 1),
    "deep": (LOOPS["faults"], 3),
    "station": (systems_by_name(LOOPS["realistic"])["station"], 2),
    "sensors": (systems_by_name(LOOPS["realistic"])["sensors"], 1),
    "leaf": (systems_by_name(LOOPS["default"])["mpc"], 1),
}


@pytest.fixture(scope="module", params=DRAWN.values(), ids=DRAWN)
def drawing(request):
    return graph_of(*request.param), n2_chart(*request.param)


def name(box) -> str:
    """Without spaces, at which lines may end."""
    return "".join(box.lines[: box.names]).replace(" ", "")


def diagonal_of(graph, chart) -> dict:
    """The rectangle of each box of a drawing."""
    rectangles = sorted(chart.systems + chart.ports, key=lambda box: box.x)
    return dict(zip(graph.leaves, rectangles, strict=True))


def test_each_box_is_on_the_diagonal(drawing):
    diagonal = diagonal_of(*drawing)
    assert all(name(shown) == box.label.replace(" ", "") for box, shown in diagonal.items())
    diagonal = list(diagonal.values())
    for before, after in zip(diagonal, diagonal[1:], strict=False):
        assert before.y < after.y
        assert before.x + before.width / 2 < after.x - after.width / 2


def test_each_signal_is_in_the_row_of_its_source_and_the_column_of_its_target(drawing):
    graph, chart = drawing
    at = diagonal_of(graph, chart)
    assert {(box.y, box.x, name(box._replace(names=99))) for box in chart.signals} == {
        (at[arrow.source].y, at[arrow.target].x, "".join(arrow.signals or names_of(arrow.source)))
        for arrow in graph.arrows
    }
    assert {tuple(line) for line in chart.lines} == {
        (at[arrow.source].x, at[arrow.source].y, at[arrow.target].x, at[arrow.target].y)
        for arrow in graph.arrows
    }


def names_of(box) -> str:
    return box.label.replace(" ", "")


def test_boxes_do_not_overlap(drawing):
    _, chart = drawing
    for a, b in combinations(chart.systems + chart.ports + chart.signals, 2):
        apart_x = abs(a.x - b.x) - (a.width + b.width) / 2
        apart_y = abs(a.y - b.y) - (a.height + b.height) / 2
        assert max(apart_x, apart_y) > 0


def test_everything_is_inside(drawing):
    _, chart = drawing
    for box in chart.systems + chart.ports + chart.signals + chart.frames:
        assert box.width / 2 <= box.x <= chart.width - box.width / 2
        assert box.height / 2 <= box.y <= chart.height - box.height / 2


def test_frames_are_around_their_systems(drawing):
    """One is within another or apart from it."""
    graph, chart = drawing
    opened = [box for top in graph.boxes for box in _opened(top)]
    assert [frame.lines for frame in chart.frames] == [(box.label,) for box in opened]
    of_box = diagonal_of(graph, chart)
    for frame, box in zip(chart.frames, opened, strict=True):
        for leaf in graph.leaves:
            inside = of_box[leaf]
            gap = (frame.width - inside.width) / 2 - abs(frame.x - inside.x)
            assert (gap > 0) if leaf in box.leaves else (gap <= -inside.width)


def _opened(box):
    if box.inside:
        yield box
        for inner in box.inside:
            yield from _opened(inner)


@pytest.mark.parametrize(
    ("loop", "system", "inside"),
    [
        ("default", "guidance", ("reference", "reference_guard")),
        ("faults", "sensors", ("sensor_noise", "sampler", "sample_nan_1", "state_filter")),
    ],
)
def test_systems_inside_a_system_are_named(loop, system, inside):
    (box,) = (box for box in n2_chart(LOOPS[loop], 2).systems if name(box) == system)
    assert box.lines[box.names :] == inside


@pytest.mark.parametrize(
    ("loop", "there", "not_there"), [("clik", "clik", "mpc"), ("pointing", "pointing", "clik")]
)
def test_it_shows_the_systems_of_the_scenario(loop, there, not_there):
    names = {name(box) for box in n2_chart(LOOPS[loop], 2).systems}
    assert there in names and not_there not in names


def test_it_is_well_formed():
    builder = DiagramBuilder()
    builder.AddNamedSystem("<a & b>", Gain(1.0, 1))
    for diagram, depth in [(builder.Build(), 1), *DRAWN.values()]:
        root = ElementTree.fromstring(n2_svg(diagram, depth))
        assert root.tag == "{http://www.w3.org/2000/svg}svg"
        words = {text.text for text in root.iter("{http://www.w3.org/2000/svg}text")}
        assert {line for box in n2_chart(diagram, depth).systems for line in box.lines} <= words


def test_text_fits_its_boxes_in_a_browser():
    """Each text is within one rectangle that is no frame, to half a unit."""
    with chromium() as browser:
        page = browser.new_page()
        for drawn, (system, depth) in DRAWN.items():
            page.set_content(n2_svg(system, depth))
            outside = page.evaluate(
                """() => {
                    const [rects, texts] = ['rect:not(.side):not(.ground)', 'text:not(.side)'].map(
                        kind => [...document.querySelectorAll(kind)].map(e => e.getBBox()));
                    return texts.filter(text => !rects.some(rect =>
                        text.x > rect.x - 0.5 && text.x + text.width < rect.x + rect.width + 0.5 &&
                        text.y > rect.y - 0.5 && text.y + text.height < rect.y + rect.height + 0.5
                    )).length;
                }"""
            )
            assert outside == 0, drawn


def test_it_is_readable_on_a_screen():
    """The letters of the closed loop are 8 px or more on 1,200 px."""
    width = float(re.search(r'viewBox="0 0 ([\d.]+)', n2_svg(LOOPS["default"], 2))[1])
    assert 10 * 1200 / width > 8
