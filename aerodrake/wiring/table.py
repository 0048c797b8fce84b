"""Connections between systems as tables of names."""

from dataclasses import dataclass, replace
from typing import Self

from pydrake.systems.framework import Diagram, DiagramBuilder


def shared_input(name: str, *systems: str) -> tuple[tuple[str, str, str], ...]:
    """Returns rows of `Wiring.inputs` that connect an input to the ports of its name."""
    return tuple((name, system, name) for system in systems)


def outputs(system: str, *ports: str) -> tuple[tuple[str, str, str], ...]:
    """Returns rows of `Wiring.outputs` that export ports by their own names."""
    return tuple((system, port, port) for port in ports)


@dataclass(frozen=True)
class Wiring:
    """Connections of the systems in a DiagramBuilder, and the ports that their diagram exports.

    Attributes:
        connections: Rows of (source system, output port, target system, input port).
        inputs: Rows of (name, target system, input port). Rows of one name share one input.
        outputs: Rows of (source system, output port, name).
    """

    connections: tuple[tuple[str, str, str, str], ...] = ()
    inputs: tuple[tuple[str, str, str], ...] = ()
    outputs: tuple[tuple[str, str, str], ...] = ()

    def __add__(self, other: Self) -> Self:
        """Returns the rows of both."""
        return Wiring(
            self.connections + other.connections,
            self.inputs + other.inputs,
            self.outputs + other.outputs,
        )

    def rename(self, old: str, new: str) -> Self:
        """Returns these rows with another name for a system."""

        def renamed(system: str) -> str:
            return new if system == old else system

        return Wiring(
            tuple((renamed(a), p, renamed(b), q) for a, p, b, q in self.connections),
            tuple((name, renamed(system), port) for name, system, port in self.inputs),
            tuple((renamed(system), port, name) for system, port, name in self.outputs),
        )

    def insert(self, name: str, system: str, port: str) -> Self:
        """Returns these rows with a `SymbolicVectorSystem` inserted behind an output port.

        Args:
            name: The inserted system, with input `u0` and output `y0`.
            system, port: The output port; its targets and its export move to `y0`.
        """

        def moved(source: tuple[str, str]) -> tuple[str, str]:
            return (name, "y0") if source == (system, port) else source

        connections = tuple((*moved(row[:2]), *row[2:]) for row in self.connections)
        return replace(
            self,
            connections=(*connections, (system, port, name, "u0")),
            outputs=tuple((*moved(row[:2]), row[2]) for row in self.outputs),
        )

    def apply(self, builder: DiagramBuilder) -> None:
        """Connects and exports the ports of systems that are in the builder.

        Raises:
            RuntimeError: if a system or port does not exist.
        """
        system = builder.GetSubsystemByName
        for source, output, target, port in self.connections:
            builder.Connect(system(source).GetOutputPort(output), system(target).GetInputPort(port))
        exported: set[str] = set()
        for name, target, port in self.inputs:
            if name in exported:
                builder.ConnectInput(name, system(target).GetInputPort(port))
            else:
                builder.ExportInput(system(target).GetInputPort(port), name)
                exported.add(name)
        for source, output, name in self.outputs:
            builder.ExportOutput(system(source).GetOutputPort(output), name)

    def build(self, builder: DiagramBuilder, name: str) -> Diagram:
        """Applies these rows, and returns the diagram of the builder's systems by its name."""
        self.apply(builder)
        diagram = builder.Build()
        diagram.set_name(name)
        return diagram
