"""Graphviz text: valid, and drawn in the rows of the drawing."""

import re
import shutil
import subprocess
from itertools import combinations

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain

from aerodrake.gallery.dot import to_dot
from aerodrake.gallery.graph import graph_of, systems_by_name
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop

SYSTEMS = systems_by_name(make_closed_loop(Scenario()))

NODE = re.compile(r'^ *"([^"]+)" \[label="', re.MULTILINE)
EDGE = re.compile(r'^ *"([^"]+)" -> "([^"]+)" \[', re.MULTILINE)


@pytest.mark.parametrize("depth", [0, 1, 2, 3])
def test_every_box_and_arrow_is_written(depth):
    for name, system in SYSTEMS.items():
        text, graph = to_dot(system, depth), graph_of(system, depth)
        assert sorted(NODE.findall(text)) == sorted(box.id for box in graph.leaves), name
        written = [frozenset(ends) for ends in EDGE.findall(text)]
        drawn = [frozenset((arrow.source.id, arrow.target.id)) for arrow in graph.arrows]
        assert sorted(map(sorted, written)) == sorted(map(sorted, drawn)), name
        assert text.count("dir=back") == sum(arrow.is_feedback for arrow in graph.arrows)
        assert text.count("{") == text.count("}")
        assert not re.search(r"0x|[0-9a-f]{12}", text), "an address"


def test_names_are_quoted():
    builder = DiagramBuilder()
    builder.AddNamedSystem('a "strange" \\ name', Gain(1.0, 1))
    assert r'label="a \"strange\" \\ name"' in to_dot(builder.Build(), 1)


@pytest.mark.skipif(shutil.which("dot") is None, reason="needs Graphviz")
@pytest.mark.parametrize(
    ("name", "depth"), [("closed_loop", 2), ("closed_loop", 3), ("station", 1)]
)
def test_graphviz_draws_the_rows(name, depth):
    """Boxes are in the rows of the drawing; labels do not overlap; and it fits a screen."""
    text = subprocess.run(
        ["dot", "-Tplain"],
        input=to_dot(SYSTEMS[name], depth).encode(),
        capture_output=True,
        check=True,
    ).stdout.decode()
    lines = [line.split(" ") for line in text.splitlines()]
    width_in = float(lines[0][2])
    assert width_in < 17  # 1,600 px at 96 px an inch.
    heights = {line[1].strip('"'): float(line[3]) for line in lines if line[0] == "node"}
    for upper, lower in combinations(graph_of(SYSTEMS[name], depth).leaves, 2):
        if upper.rank == lower.rank:
            assert heights[upper.id] == pytest.approx(heights[lower.id], abs=0.02)
        elif upper.rank < lower.rank:
            assert heights[upper.id] > heights[lower.id]
        else:
            assert heights[upper.id] < heights[lower.id]
    for (ax, ay, aw, ah), (bx, by, bw, bh) in combinations(_edge_labels(text), 2):
        assert abs(ax - bx) >= (aw + bw) / 2 or abs(ay - by) >= (ah + bh) / 2


def _edge_labels(plain: str) -> list[tuple[float, float, float, float]]:
    """Centre and size in inches of each label, of 10 points, about 5 points a character."""
    boxes = []
    for label, x, y in re.findall(r'^edge .* "(.*?)" ([\d.]+) ([\d.]+) solid', plain, re.MULTILINE):
        rows = [row.strip() for row in label.split("\\n")]
        boxes.append((float(x), float(y), 5 / 72 * max(map(len, rows)), 11 / 72 * len(rows)))
    return boxes
