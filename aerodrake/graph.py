"""Graphs of diagrams and systems, as Graphviz and Mermaid text.

Both are functions of the wiring alone: the same diagram gives the same bytes in
every process, so that graphs can be committed and compared.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Iterable, Iterator
from itertools import groupby
from pathlib import Path
from typing import Any

from pydrake.systems.framework import (
    Diagram,
    InputPortIndex,
    OutputPortIndex,
    PortDataType,
    System,
)

from aerodrake.errors import BadInput, nearest

DOT_TIMEOUT_S = 60.0
"""Graphviz lays out the closed loop in a fraction of this."""


def systems_by_name(diagram: Diagram) -> dict[str, System]:
    """The diagram itself, every diagram in it and every leaf system, by name.

    Raises:
        ValueError: if two of them share a name, or one has none.
    """
    systems: dict[str, System] = {}
    for system in _systems(diagram):
        name = system.get_name()
        if not name or name in systems:
            raise ValueError(
                f"expected a name of its own for every system in {diagram.get_name()}, "
                f"got '{name}'" + " twice" * bool(name)
            )
        systems[name] = system
    return systems


def to_dot(system: System, depth: int) -> str:
    """Drake's own drawing, with every port, as Graphviz text.

    Args:
        system: A diagram or a leaf system.
        depth: Levels of diagrams to open; 0 draws one box.
    """
    ids: dict[str, int] = {}

    def renumber(match: re.Match[str]) -> str:
        return f"{match[1]}{ids.setdefault(match[2], len(ids) + 1)}"

    # Drake's ids count the systems built by the process so far, and its edges
    # come in the order of the systems' addresses.
    text = re.sub(
        r"(^digraph _|^subgraph clusters?|^s| -> s)(\d+)",
        renumber,
        system.GetGraphvizString(max_depth=depth),
        flags=re.MULTILINE,
    )
    lines: list[str] = []
    for are_edges, block in groupby(text.rstrip().split("\n"), lambda line: " -> " in line):
        lines += sorted(block, key=_numbers) if are_edges else block
    return "\n".join(lines) + "\n"


def to_mermaid(system: System, depth: int) -> str:
    """The signals between systems, as a Mermaid flowchart.

    An arrow joins two systems and lists its signals by the names of their
    ports. Rounded nodes are the ports of `system` itself, with their sizes. A
    diagram without inputs is a closed loop: once opened, its outputs only
    repeat what is seen inside, and are left out.

    Args:
        system: A diagram or a leaf system.
        depth: Levels of diagrams to open; 0 draws one box.
    """
    ports: list[str] = []
    arrows: dict[tuple[str, str], list[str]] = {}

    def add_port(node: str, port: Any) -> None:
        ports.append(f'  {node}(["{port.get_name()} ({_size(port)})"])')

    def add_arrow(source: str, target: str, *port_names: str) -> None:
        signal = " → ".join(dict.fromkeys(name for name in port_names if name))
        arrows.setdefault((source, target), []).append(signal)

    for i in range(system.num_input_ports()):
        port = system.get_input_port(i)
        name = port.get_name()
        add_port(f"in_{name}", port)
        for target, target_port in _targets(system, i, depth):
            add_arrow(
                f"in_{name}", target.get_name(), _name(target.get_input_port(target_port), name)
            )
    for source, source_port, target, target_port in _connections(system, depth):
        add_arrow(
            source.get_name(),
            target.get_name(),
            _name(source.get_output_port(source_port)),
            _name(target.get_input_port(target_port)),
        )
    if not (_opens(system, depth) and system.num_input_ports() == 0):
        for i in range(system.num_output_ports()):
            port = system.get_output_port(i)
            name = port.get_name()
            add_port(f"out_{name}", port)
            source, source_port = _source(system, i, depth)
            add_arrow(
                source.get_name(), f"out_{name}", _name(source.get_output_port(source_port), name)
            )
    lines = ["flowchart LR", *_boxes(system, depth), *ports]
    for (a, b), signals in arrows.items():
        label = "<br/>".join(s for s in signals if s)
        lines.append(f'  {a} -->|"{label}"| {b}' if label else f"  {a} --> {b}")
    return "\n".join(lines) + "\n"


def _name(port, known=""):
    name = port.get_name()
    return "" if name == known or re.fullmatch(r"[uy]\d+", name) else name


def _size(port: Any) -> str:
    return "abstract" if port.get_data_type() == PortDataType.kAbstractValued else str(port.size())


def _boxes(system: System, depth: int) -> Iterator[str]:
    if not _opens(system, depth):
        yield f"  {system.get_name()}"
        return
    for inner in system.GetSystems():
        if _opens(inner, depth - 1):
            yield f"  subgraph {inner.get_name()}"
            yield from ("  " + line for line in _boxes(inner, depth - 1))
            yield "  end"
        else:
            yield from _boxes(inner, depth - 1)


def _connections(system: System, depth: int):
    if not _opens(system, depth):
        return
    sources = system.connection_map()
    for target in system.GetSystems():
        for i in range(target.num_input_ports()):
            if (target, InputPortIndex(i)) in sources:
                source, o = sources[target, InputPortIndex(i)]
                for end in _targets(target, i, depth - 1):
                    yield *_source(source, o, depth - 1), *end
    for inner in system.GetSystems():
        yield from _connections(inner, depth - 1)


def _source(system: System, port: int, depth: int):
    while _opens(system, depth):
        system, port = system.get_output_port_locator(OutputPortIndex(port))
        depth -= 1
    return system, port


def _targets(system: System, port: int, depth: int):
    if not _opens(system, depth):
        yield system, port
        return
    order = system.GetSystems()
    for inner, inner_port in sorted(
        system.GetInputPortLocators(InputPortIndex(port)),
        key=lambda locator: (order.index(locator[0]), int(locator[1])),
    ):
        yield from _targets(inner, int(inner_port), depth - 1)


def _opens(system: System, depth: int) -> bool:
    return depth > 0 and isinstance(system, Diagram)


def _systems(system: System) -> Iterator[System]:
    yield system
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from _systems(inner)


def _numbers(line: str) -> list[int]:
    return [int(number) for number in re.findall(r"\d+", line)]
