"""Graphs as Graphviz text."""

import json
from collections.abc import Iterator

from pydrake.systems.framework import System

from aerodrake.gallery.graph import Arrow, Box, graph_of
from aerodrake.gallery.ports import opens

HEADER = """\
  graph [fontname="Helvetica", fontsize=13, nodesep=0.1, ranksep=0.2, newrank=true]
  graph [style="rounded,filled", color="#ced4da", fillcolor="#f3f6f9", bgcolor="white"]
  node [shape=box, style=filled, fillcolor=white, fontname="Helvetica", fontsize=13]
  node [margin="0.1,0.05", height=0, width=0]
  edge [fontname="Helvetica", fontsize=10, arrowsize=0.6, color="#495057", fontcolor="#343a40"]
"""
"""Attributes for a width of about 1,500 pixels of the closed loop with all sub-diagrams open."""


def to_dot(system: System, depth: int) -> str:
    """Returns the drawing of `graph_of` as Graphviz text, of the same rows.

    Signals that are fed back are drawn upwards, in another colour.
    """
    graph = graph_of(system, depth)
    direction = "TB" if opens(system, depth) else "LR"
    lines = [f"rankdir={direction}", *_boxes(graph.boxes), *map(_edge, graph.arrows)]
    return "digraph {\n" + HEADER + "".join(f"  {line}\n" for line in lines) + "}\n"


def _boxes(boxes: tuple[Box, ...]) -> Iterator[str]:
    for box in boxes:
        if box.inside:
            yield f"subgraph {_quoted('cluster_' + box.id)} {{"
            yield f"  label={_quoted(box.label)}"
            yield from (f"  {line}" for line in _boxes(box.inside))
            yield "}"
        else:
            style = ', shape=plain, style=solid, fontcolor="#495057"' if box.system is None else ""
            yield f"{_quoted(box.id)} [label={_quoted(box.label)}{style}]"


def _edge(arrow: Arrow) -> str:
    label = "\n".join(f" {signal} " for signal in arrow.signals)  # Spaces keep lines away.
    upper, lower = arrow.source, arrow.target
    attributes = [f"label={_quoted(label)}"] if label else []
    if arrow.is_feedback:
        # Written downwards, since edges determine the rows.
        upper, lower = lower, upper
        attributes += ["dir=back", 'color="#c2410c"', 'fontcolor="#c2410c"']
    attributes.append(f"minlen={lower.rank - upper.rank}")
    return f"{_quoted(upper.id)} -> {_quoted(lower.id)} [{', '.join(attributes)}]"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
