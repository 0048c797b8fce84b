"""Graphs as Mermaid text."""

from collections.abc import Iterator

from pydrake.systems.framework import System

from aerodrake.gallery.graph import Arrow, Box, graph_of
from aerodrake.gallery.ports import opens

LAYOUT = (
    '%%{init: {"flowchart": {"curve": "monotoneY", "nodeSpacing": 20, "rankSpacing": 30, '
    '"subGraphTitleMargin": {"bottom": 12}}}}%%'
)
"""Curves that pass through their labels, and short distances."""

RESERVED = {"end", "graph", "subgraph", "default", "style", "class", "click", "href", "call"}
"""Words that cannot be the id of a box."""


def to_mermaid(system: System, depth: int) -> str:
    """Returns the drawing of `graph_of` as a Mermaid flowchart; dotted arrows are feedback.

    An invisible link joins all boxes of an opened diagram in signal order, one in each row, so
    that the layout engine breaks cycles at the feedback.
    """
    graph = graph_of(system, depth)
    lines = ["flowchart LR", *_boxes(graph.boxes), *map(_arrow, graph.arrows)]
    if opens(system, depth):
        order = " ~~~ ".join(map(_id, graph.leaves))
        lines = ["flowchart TB", LAYOUT, *_boxes(graph.boxes), order, *map(_arrow, graph.arrows)]
    return "\n  ".join(lines) + "\n"


def _boxes(boxes: tuple[Box, ...]) -> Iterator[str]:
    for box in boxes:
        name = _id(box) if _id(box) == box.label else f'{_id(box)}["{_escaped(box.label)}"]'
        if box.inside:
            yield f"subgraph {name}"
            yield from (f"  {line}" for line in _boxes(box.inside))
            yield "end"
        elif box.system is None:
            yield f'{_id(box)}(["{_escaped(box.label)}"])'
        else:
            yield name


def _arrow(arrow: Arrow) -> str:
    link = "-.->" if arrow.is_feedback else "-->"
    label = "<br/>".join(map(_escaped, arrow.signals))
    labelled = f' {link}|"{label}"| ' if label else f" {link} "
    return labelled.join((_id(arrow.source), _id(arrow.target)))


def _id(box: Box) -> str:
    return box.id + "_" * (box.id in RESERVED)


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
