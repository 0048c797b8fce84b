"""Mermaid text: every box and arrow, in the order of the signals."""

import re

from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Gain

from aerodrake.gallery.graph import graph_of, systems_by_name
from aerodrake.gallery.mermaid import LAYOUT, to_mermaid
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop

SYSTEMS = systems_by_name(make_closed_loop(Scenario()))


def test_text():
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("two", ConstantVectorSource([2.0]))
    adder = builder.AddNamedSystem("end", Adder(2, 1))
    gain = builder.AddNamedSystem("half of <it>", Gain(0.5, 1))
    builder.Connect(source.get_output_port(), adder.get_input_port(0))
    builder.Connect(adder.get_output_port(), gain.get_input_port())
    builder.ExportInput(adder.get_input_port(1), "offset")
    builder.ExportOutput(adder.get_output_port(), "total")
    expected = f"""\
flowchart TB
  {LAYOUT}
  inputs(["inputs"])
  two
  end_["end"]
  half_of_it_["half of &lt;it>"]
  outputs(["outputs"])
  inputs ~~~ two ~~~ end_ ~~~ half_of_it_ ~~~ outputs
  inputs -->|"offset"| end_
  two --> end_
  end_ -->|"sum"| half_of_it_
  end_ -->|"total"| outputs
"""
    assert to_mermaid(builder.Build(), 1) == expected


def test_every_box_and_arrow_is_written():
    for name, system in SYSTEMS.items():
        for depth in range(4):
            text, graph = to_mermaid(system, depth), graph_of(system, depth)
            arrows = re.findall(r'(?m)^  (\w+) (-->|-\.->)(?:\|"(.*)"\|)? (\w+)$', text)
            assert arrows == [
                (
                    a.source.id,
                    "-.->" if a.is_feedback else "-->",
                    "<br/>".join(a.signals),
                    a.target.id,
                )
                for a in graph.arrows
            ], name
            declared = re.findall(r"(?m)^ +(\w+)(?:\(\[.*\]\))?$", text)
            assert [box for box in declared if box != "end"] == [box.id for box in graph.leaves]
            if "~~~" in text:
                (order,) = re.findall(r"(?m)^  (.* ~~~ .*)$", text)
                assert order.split(" ~~~ ") == [box.id for box in graph.leaves]


def test_diagrams_are_subgraphs():
    text = to_mermaid(SYSTEMS["closed_loop"], 3)
    opened = re.findall(r"(?m)^ +subgraph (\w+)$", text)
    assert opened == ["station", "physics", "sensors", "coordinator", "guidance"]
    assert len(re.findall(r"(?m)^ +end$", text)) == len(opened)
