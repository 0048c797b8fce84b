"""Ports of systems, and the connections between systems at a level of nested diagrams."""

import re
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


def is_default(name: str) -> bool:
    """Returns True for a default name of Drake's, such as `u0`."""
    return re.fullmatch(r"[uy]\d+", name) is not None


def opens(system: System, depth: int) -> bool:
    """Returns True if a drawing with `depth` levels of diagrams shows what is in the system."""
    return depth > 0 and isinstance(system, Diagram)


def connections(system: System, depth: int) -> Iterator[tuple[OutputPort, InputPort]]:
    """Yields the signals between the boxes of a drawing, in no particular order."""
    if not opens(system, depth):
        return
    for (target, i), (source, o) in system.connection_map().items():
        for port in targets(target.get_input_port(i), depth - 1):
            yield box_output(source.get_output_port(o), depth - 1), port
    for inner in system.GetSystems():
        yield from connections(inner, depth - 1)


def box_output(port: OutputPort, depth: int) -> OutputPort:
    """Returns the port of a box of a drawing that an output exports."""
    system = port.get_system()
    if not opens(system, depth):
        return port
    inner, index = system.get_output_port_locator(port.get_index())
    return box_output(inner.get_output_port(index), depth - 1)


def targets(port: InputPort, depth: int) -> Iterator[InputPort]:
    """Yields the ports of boxes of a drawing that an input is exported from."""
    system = port.get_system()
    if not opens(system, depth):
        yield port
        return
    for inner, index in system.GetInputPortLocators(port.get_index()):
        yield from targets(inner.get_input_port(index), depth - 1)
