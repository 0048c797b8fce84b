"""N-squared chart of a diagram: systems on the diagonal, signals beside it.

A signal is in the row of its source and in the column of its target: signals right of the
diagonal are fed forward, signals left of it are fed back. Its label is the name of its port, or
of its system if the port has a default name. Opened diagrams have frames.
"""

import re
from collections.abc import Collection, Iterator
from itertools import accumulate
from typing import NamedTuple

from pydrake.systems.framework import Diagram, System

from aerodrake.gallery.graph import Box, graph_of
from aerodrake.support.templates import render_template

CHARACTER, LINE = 6.1, 13.0
"""Width and height of a character, in units of the chart."""
PADDING, GAP = 5.0, 6.0
"""Distance from text to its box, and between boxes."""
LONGEST = 10
"""Largest number of characters in a line of a name with underscores."""
MARGIN = 10.0
ALL_LEVELS = 1000
"""Depth that opens all levels of diagrams."""


class Rectangle(NamedTuple):
    """A box of the chart.

    Attributes:
        lines: Lines of its name, then the names of the systems in it.
        names: Number of lines of its own name.
        x, y: Its centre, in units of the chart.
        width, height: Its size, in units of the chart.
    """

    lines: tuple[str, ...]
    names: int
    x: float
    y: float
    width: float
    height: float


class Line(NamedTuple):
    """A horizontal line from a system to the column of another, then a vertical one to that."""

    x: float
    y: float
    to_x: float
    to_y: float


class Frame(NamedTuple):
    """Frame of an opened diagram, around the boxes `first` to `last` of the diagonal."""

    name: str
    first: int
    last: int


class Chart(NamedTuple):
    """Layout of the chart.

    Attributes:
        systems: Boxes on the diagonal.
        ports: Boxes of the diagram's inputs and outputs, at the ends of the diagonal.
        signals: Boxes of the signals.
        frames: Frames of opened diagrams, outer ones first.
        lines: Lines of the signals, behind the boxes.
        width, height: Size of the chart.
    """

    systems: list[Rectangle]
    ports: list[Rectangle]
    signals: list[Rectangle]
    frames: list[Rectangle]
    lines: list[Line]
    width: float
    height: float


def n2_svg(system: System, depth: int, without: Collection[str] = ()) -> str:
    """Returns the chart of a system as SVG; the arguments are those of `graph_of`."""
    chart = n2_chart(system, depth, without)
    return render_template("aerodrake.gallery", "n2_chart.svg", chart=chart, line=LINE)


def n2_chart(system: System, depth: int, without: Collection[str] = ()) -> Chart:
    """Lays out the boxes and arrows of `graph_of`, without arrows from a system to itself."""
    graph = graph_of(system, depth, without)
    diagonal, frames = graph.leaves, list(_frames(graph.boxes, 0))
    place = {box.id: i for i, box in enumerate(diagonal)}
    texts = {(i, i): (*_split(box.label), *_inner(box)) for i, box in enumerate(diagonal)}
    signals = {
        (place[arrow.source.id], place[arrow.target.id]): tuple(
            line for name in arrow.signals or [arrow.source.label] for line in _split(name)
        )
        for arrow in graph.arrows
        if arrow.source != arrow.target
    }
    texts |= signals
    widths, heights = [0.0] * len(diagonal), [0.0] * len(diagonal)
    for (row, column), lines in texts.items():
        widths[column] = max(widths[column], _width(lines) + 2 * PADDING)
        heights[row] = max(heights[row], _height(lines) + 2 * PADDING)
    left = _starts(widths, frames, GAP)
    top = _starts(heights, frames, GAP + LINE)

    def rectangle(row: int, column: int, names: int) -> Rectangle:
        lines = texts[row, column]
        x, y = left[column] + widths[column] / 2, top[row] + heights[row] / 2
        if row == column:
            return Rectangle(lines, names, x, y, widths[column], heights[row])
        return Rectangle(lines, names, x, y, _width(lines) + PADDING, _height(lines) + PADDING)

    boxes = [rectangle(i, i, len(_split(box.label))) for i, box in enumerate(diagonal)]
    margin = MARGIN + sum(frame.last == len(diagonal) - 1 for frame in frames) * GAP
    return Chart(
        systems=[boxes[i] for i, box in enumerate(diagonal) if box.system is not None],
        ports=[boxes[i] for i, box in enumerate(diagonal) if box.system is None],
        signals=[rectangle(*ends, names=0) for ends in sorted(signals)],
        frames=[_frame(frame, boxes, frames) for frame in frames],
        lines=[Line(boxes[i].x, boxes[i].y, boxes[j].x, boxes[j].y) for i, j in sorted(signals)],
        width=left[-1] + widths[-1] + margin,
        height=top[-1] + heights[-1] + margin,
    )


def _frames(boxes: tuple[Box, ...], first: int) -> Iterator[Frame]:
    """Yields the frames of opened boxes, the leftmost box of which is the `first` one."""
    for box in boxes:
        count = len(box.leaves)
        if box.inside:
            yield Frame(box.label, first, first + count - 1)
            yield from _frames(box.inside, first)
        first += count


def _starts(sizes: list[float], frames: list[Frame], edge: float) -> list[float]:
    """Returns where each box begins; a frame begins `edge` before its first box."""
    before = [
        edge * sum(frame.first == i for frame in frames)
        + GAP * sum(frame.last == i - 1 for frame in frames)
        + GAP
        for i in range(len(sizes))
    ]
    before[0] += MARGIN - GAP
    ends = accumulate(size + space for size, space in zip(sizes, before, strict=True))
    return [end - size for end, size in zip(ends, sizes, strict=True)]


def _frame(frame: Frame, boxes: list[Rectangle], frames: list[Frame]) -> Rectangle:
    inner = [f for f in frames if frame.first <= f.first and f.last <= frame.last]
    at_first = sum(f.first == frame.first for f in inner)
    at_last = sum(f.last == frame.last for f in inner)
    first, last = boxes[frame.first], boxes[frame.last]
    left = first.x - first.width / 2 - at_first * GAP
    top = first.y - first.height / 2 - at_first * (GAP + LINE)
    right = last.x + last.width / 2 + at_last * GAP
    bottom = last.y + last.height / 2 + at_last * GAP
    middle = ((left + right) / 2, (top + bottom) / 2)
    return Rectangle((frame.name,), 1, *middle, right - left, bottom - top)


def _width(lines: tuple[str, ...]) -> float:
    return CHARACTER * max(map(len, lines))


def _height(lines: tuple[str, ...]) -> float:
    return LINE * len(lines)


def _split(name: str) -> tuple[str, ...]:
    """Splits a name after underscores and spaces into lines of `LONGEST` characters or fewer."""
    lines = [""]
    for part in re.findall(r"[^_ ]+[_ ]*|[_ ]+", name):
        if lines[-1] and len((lines[-1] + part).rstrip()) > LONGEST:
            lines.append("")
        lines[-1] += part
    return tuple(line.rstrip() for line in lines)


def _inner(box: Box) -> tuple[str, ...]:
    """Returns the names of the leaf systems in a box of a diagram; none for a leaf system."""
    if not isinstance(box.system, Diagram):
        return ()
    leaves = graph_of(box.system, ALL_LEVELS).leaves
    return tuple(leaf.label for leaf in leaves if leaf.system is not None)
