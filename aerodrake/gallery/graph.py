"""Graphs of diagrams and systems, as Graphviz and Mermaid text.

Both depend only on the wiring. A diagram gives the same bytes in every process,
so that its graphs can be committed and compared. `system` is a diagram or a leaf system;
`depth` is the number of levels of diagrams to open, and 0 draws one box.
"""

import re
from collections import defaultdict
from collections.abc import Iterator

from pydrake.systems.framework import Diagram, InputPort, OutputPort, PortDataType, System

Port = InputPort | OutputPort


def input_ports(system: System) -> list[InputPort]:
    """Returns the inputs, without ports of size zero, which plants have for absent parts."""
    ports = map(system.get_input_port, range(system.num_input_ports()))
    return [port for port in ports if size(port) != "0"]


def output_ports(system: System) -> list[OutputPort]:
    """Returns the outputs, without ports of size zero."""
    ports = map(system.get_output_port, range(system.num_output_ports()))
    return [port for port in ports if size(port) != "0"]


def size(port: Port) -> str:
    """Returns the size of a port as text; `abstract` if it has none."""
    is_abstract = port.get_data_type() == PortDataType.kAbstractValued
    return "abstract" if is_abstract else str(port.size())


def systems_by_name(system: System) -> dict[str, System]:
    """Returns a system and, if it is a diagram, all systems in it, by name.

    Raises:
        ValueError: if two of them share a name, or one has no name.
    """
    systems: dict[str, System] = {}
    for inner in _systems(system):
        name = inner.get_name()
        if not re.fullmatch(r"\w+", name) or name in systems:
            problem = f"two named '{name}'" if name in systems else f"'{name}'"
            raise ValueError(f"expected a different word as each system's name, got {problem}")
        systems[name] = inner
    return systems


def to_dot(system: System, depth: int) -> str:
    """Returns Drake's own graph, with every port, as Graphviz text."""
    ids: dict[str, int] = {}

    def renumber(match: re.Match[str]) -> str:
        return f"{match[1]}{ids.setdefault(match[2], len(ids) + 1)}"

    def sort_edges(match: re.Match[str]) -> str:
        return "".join(sorted(match[0].splitlines(keepends=True), key=_natural))

    # Drake numbers the systems of the whole process, and orders edges by address.
    text = system.GetGraphvizString(max_depth=depth).rstrip() + "\n"
    text = re.sub(r"(?m)(^digraph _|^subgraph clusters?|^s| -> s)(\d+)", renumber, text)
    return re.sub(r"(?m)(^s\d+.* -> .*\n)+", sort_edges, text)


def to_mermaid(system: System, depth: int) -> str:
    """Returns the signals between systems as a Mermaid flowchart.

    An arrow joins two systems and lists its signals by the names of their
    ports, without Drake's default names such as `u0`. Rounded nodes are the
    ports of `system` with their sizes, except ports of size zero. An open
    diagram without inputs is a closed loop, whose outputs are left out.

    Raises:
        ValueError: as `systems_by_name`.
    """
    names = systems_by_name(system)
    opened = _opens(system, depth)
    inputs = {f"in_{port.get_name()}": port for port in input_ports(system)}
    outputs = {f"out_{port.get_name()}": port for port in output_ports(system)}
    if opened and not inputs:
        outputs = {}

    arrows: dict[tuple[str, str], set[str]] = defaultdict(set)
    for node, port in inputs.items():
        for target in _targets(port, depth):
            arrows[node, _box(target)].add(_signal(target, known=port))
    for source, target in connections(system, depth):
        arrows[_box(source), _box(target)].add(_signal(source, target))
    for node, port in outputs.items():
        source = _source(port, depth)
        arrows[_box(source), node].add(_signal(source, known=port))

    lines = [
        "flowchart TB" if opened else "flowchart LR",  # The narrower of the two.
        *(_rounded(node, port) for node, port in inputs.items()),
        *_boxes(system, depth),
        *(_rounded(node, port) for node, port in outputs.items()),
    ]
    # Layout engines break cycles in the order of the text.
    order = [*inputs, *names, *outputs]
    for arrow in sorted(arrows, key=lambda ends: [order.index(end) for end in ends]):
        label = "<br/>".join(sorted(arrows[arrow] - {""}))
        lines.append((f' -->|"{label}"| ' if label else " --> ").join(arrow))
    return "\n  ".join(lines) + "\n"


def _boxes(system: System, depth: int) -> Iterator[str]:
    """Yields the lines that declare systems, open ones as subgraphs."""
    if not _opens(system, depth):
        yield system.get_name()
        return
    for inner in system.GetSystems():
        if _opens(inner, depth - 1):
            yield f"subgraph {inner.get_name()}"
            yield from (f"  {line}" for line in _boxes(inner, depth - 1))
            yield "end"
        else:
            yield inner.get_name()


def _rounded(node: str, port: Port) -> str:
    return f'{node}(["{port.get_name()} ({size(port)})"])'


def _box(port: Port) -> str:
    return port.get_system().get_name()


def _signal(*ports: Port, known: Port | None = None) -> str:
    """Returns the names of ports for their signal, except the name of a `known` port."""
    names = dict.fromkeys(port.get_name() for port in ports)
    if known is not None:
        names.pop(known.get_name(), None)
    return " → ".join(name for name in names if not is_default(name))


def is_default(name: str) -> bool:
    """Returns True for a default name of Drake's, such as `u0`."""
    return re.fullmatch(r"[uy]\d+", name) is not None


def connections(system: System, depth: int) -> Iterator[tuple[OutputPort, InputPort]]:
    """Yields the signals between boxes of the graph, in no particular order."""
    if not _opens(system, depth):
        return
    for (target, i), (source, o) in system.connection_map().items():
        for port in _targets(target.get_input_port(i), depth - 1):
            yield _source(source.get_output_port(o), depth - 1), port
    for inner in system.GetSystems():
        yield from connections(inner, depth - 1)


def _source(port: OutputPort, depth: int) -> OutputPort:
    """Returns the port of a box that is the source of an output."""
    system = port.get_system()
    if not _opens(system, depth):
        return port
    inner, index = system.get_output_port_locator(port.get_index())
    return _source(inner.get_output_port(index), depth - 1)


def _targets(port: InputPort, depth: int) -> Iterator[InputPort]:
    """Yields the ports of boxes that are targets of an input."""
    system = port.get_system()
    if not _opens(system, depth):
        yield port
        return
    for inner, index in system.GetInputPortLocators(port.get_index()):
        yield from _targets(inner.get_input_port(index), depth - 1)


def _opens(system: System, depth: int) -> bool:
    return depth > 0 and isinstance(system, Diagram)


def _systems(system: System) -> Iterator[System]:
    yield system
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from _systems(inner)


def _natural(line: str) -> list[str | int]:
    """Returns a sort key that orders numbers by value."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", line)]
