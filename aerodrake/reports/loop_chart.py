"""The closed loop as an N-squared chart: systems on the diagonal, signals beside it.

A signal is in the row of its source and in the column of its target: signals
right of the diagonal are fed forward, signals left of it are fed back. Its label is
the name of its port, or of its system if the port has a default name. The
signals from the station to the coordinator are at the top right, and the
setpoints at the bottom left.
"""

from collections import defaultdict
from itertools import accumulate
from typing import NamedTuple

from pydrake.systems.framework import Diagram, System

from aerodrake.gallery.graph import connections, is_default
from aerodrake.station import leaf_systems

SIDES = ("station", "coordinator")
CHARACTER, LINE = 6.1, 13.0
"""Width and height of a character, in units of the chart."""
PADDING, GAP = 7.0, 8.0
"""Distance from text to its box, and between boxes."""
LONGEST = 13
"""Largest number of characters in a line of a name with underscores."""
MARGIN = 10.0


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


class Chart(NamedTuple):
    """Layout of the chart.

    Attributes:
        systems, signals, sides: Boxes; those of the sides are around their systems.
        lines: Lines of the signals, behind the boxes.
        width, height: Size of the chart.
    """

    systems: list[Rectangle]
    signals: list[Rectangle]
    sides: list[Rectangle]
    lines: list[Line]
    width: float
    height: float


def loop_chart(closed_loop: Diagram) -> Chart:
    """Lays out the systems in `SIDES`, the subsystems of a closed loop."""
    sides = [closed_loop.GetSubsystemByName(name) for name in SIDES]
    # A replacement of a side may be a single system.
    insides = [side.GetSystems() if isinstance(side, Diagram) else [side] for side in sides]
    systems = [inner for inside in insides for inner in inside]
    place = {system.get_name(): i for i, system in enumerate(systems)}
    signals: dict[tuple[int, int], set[str]] = defaultdict(set)
    for source, target in connections(closed_loop, 2):
        ends = source.get_system().get_name(), target.get_system().get_name()
        if ends[0] in place and ends[1] in place:
            names = (source.get_name(), target.get_name())
            label = next((name for name in names if not is_default(name)), ends[0])
            signals[place[ends[0]], place[ends[1]]].add(label)

    names = [_split(system.get_name()) for system in systems]
    boxes = {(i, i): (*names[i], *_inner(system)) for i, system in enumerate(systems)}
    texts = boxes | {
        ends: tuple(line for label in sorted(labels) for line in _split(label))
        for ends, labels in signals.items()
    }
    count = len(systems)
    widths, heights = [0.0] * count, [0.0] * count
    for (row, column), lines in texts.items():
        widths[column] = max(widths[column], CHARACTER * max(map(len, lines)) + 2 * PADDING)
        heights[row] = max(heights[row], LINE * len(lines) + 2 * PADDING)
    starts_x = list(accumulate((w + GAP for w in widths), initial=MARGIN + GAP))
    starts_y = list(accumulate((h + GAP for h in heights), initial=MARGIN + GAP + LINE))
    # Space for the frame of each side and its name.
    first = len(insides[0])
    starts_x = [x + 3 * GAP * (i >= first) for i, x in enumerate(starts_x)]
    starts_y = [y + (3 * GAP + LINE) * (i >= first) for i, y in enumerate(starts_y)]

    def rectangle(row: int, column: int, names: int) -> Rectangle:
        lines = texts[row, column]
        x, y = starts_x[column] + widths[column] / 2, starts_y[row] + heights[row] / 2
        if row == column:
            return Rectangle(lines, names, x, y, widths[column], heights[row])
        width = CHARACTER * max(map(len, lines)) + PADDING
        return Rectangle(lines, names, x, y, width, LINE * len(lines) + PADDING)

    diagonal = [rectangle(i, i, len(names[i])) for i in range(count)]
    frames = [
        _frame(name, diagonal[start:end])
        for name, start, end in zip(SIDES, (0, first), (first, count), strict=True)
    ]
    return Chart(
        systems=diagonal,
        signals=[rectangle(*ends, names=0) for ends in sorted(signals)],
        sides=frames,
        lines=[
            Line(diagonal[i].x, diagonal[i].y, diagonal[j].x, diagonal[j].y)
            for i, j in sorted(signals)
        ],
        width=frames[-1].x + frames[-1].width / 2 + MARGIN,
        height=frames[-1].y + frames[-1].height / 2 + MARGIN,
    )


def _frame(name: str, inside: list[Rectangle]) -> Rectangle:
    left, right = inside[0].x - inside[0].width / 2 - GAP, inside[-1].x + inside[-1].width / 2 + GAP
    top = inside[0].y - inside[0].height / 2 - GAP - LINE
    bottom = inside[-1].y + inside[-1].height / 2 + GAP
    middle = ((left + right) / 2, (top + bottom) / 2)
    return Rectangle((name,), 1, *middle, right - left, bottom - top)


def _split(name: str) -> tuple[str, ...]:
    """Splits a name at underscores into lines of `LONGEST` characters or fewer."""
    lines = [""]
    for part in name.replace("_", "_ ").split():
        if lines[-1] and len(lines[-1] + part) > LONGEST:
            lines.append("")
        lines[-1] += part
    return tuple(lines)


def _inner(system: System) -> tuple[str, ...]:
    """Returns the names of the leaf systems in a diagram; none for a leaf system."""
    is_diagram = isinstance(system, Diagram)
    return tuple(inner.get_name() for inner in leaf_systems(system)) if is_diagram else ()
