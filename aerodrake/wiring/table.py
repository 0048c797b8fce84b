"""Tables of names: connections between systems, and their rates."""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

from pydrake.systems.framework import Diagram, DiagramBuilder


def shared_input(name: str, *systems: str) -> tuple[tuple[str, str, str], ...]:
    """Returns rows of `Wiring.inputs` that connect an input to the ports of its name."""
    return tuple((name, system, name) for system in systems)


def outputs(system: str, *ports: str) -> tuple[tuple[str, str, str], ...]:
    """Returns rows of `Wiring.outputs` that export ports by their own names."""
    return tuple((system, port, port) for port in ports)


OPTIONAL = frozenset(
    {
        *((name, "position_offset") for name in ("state_filter", "sensors", "station")),
        *((name, "position_offset") for name in ("setpoint_integrator", "coordinator")),
        *((name, "joint_oscillation") for name in ("state_filter", "sensors", "station")),
        *((name, "joint_oscillation") for name in ("supervisor", "coordinator")),
        *(
            (name, port)
            for name in ("sensors", "station")
            for port in ("specific_force", "specific_force_stamp", "tool_position", "tool_stamp")
        ),
        *((name, "torque_at_limit") for name in ("arm_controller", "station")),
        *((name, "torque_at_limit") for name in ("supervisor", "coordinator")),
        ("setpoint_integrator", "state"),
        *((name, "body_poses") for name in ("plant", "physics", "station")),
        *((name, "wind_velocity") for name in ("physics", "station")),
        *((name, "wind_force") for name in ("physics", "station")),
        *((name, "requested_reference") for name in ("guidance", "coordinator")),
    }
)
"""Systems and their ports that a replacement or a scenario may lack; a `Wiring` then skips their
rows."""


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
        """Returns these rows with the name `new` wherever they have `old`."""

        def renamed(rows: tuple[tuple[str, ...], ...]) -> tuple[tuple[str, ...], ...]:
            return tuple(tuple(new if name == old else name for name in row) for row in rows)

        return Wiring(renamed(self.connections), renamed(self.inputs), renamed(self.outputs))

    def insert(
        self, name: str, source: tuple[str, str], input_port: str = "u0", output_port: str = "y0"
    ) -> Self:
        """Returns these rows with a system inserted behind the output port `source`.

        Targets and export of `source`, (system, port), move to the output port of the inserted
        system `name`. Default port names are those of a `SymbolicVectorSystem`.
        """

        def moved(row: tuple[str, ...]) -> tuple[str, ...]:
            return (name, output_port, *row[2:]) if row[:2] == source else row

        return replace(
            self,
            connections=(*map(moved, self.connections), (*source, name, input_port)),
            outputs=tuple(map(moved, self.outputs)),
        )

    def insert_before(
        self, name: str, target: tuple[str, str], input_port: str = "u0", output_port: str = "y0"
    ) -> Self:
        """Returns these rows with a system inserted before the input port `target`.

        The source or input of `target`, (system, port), moves to the input port of the inserted
        system `name`. Default port names are those of a `SymbolicVectorSystem`.
        """

        def moved(row: tuple[str, ...]) -> tuple[str, ...]:
            return (*row[:-2], name, input_port) if row[-2:] == target else row

        return replace(
            self,
            connections=(*map(moved, self.connections), (name, output_port, *target)),
            inputs=tuple(map(moved, self.inputs)),
        )

    def apply(self, builder: DiagramBuilder) -> None:
        """Connects and exports the ports of systems that are in the builder.

        Raises:
            RuntimeError: if a system or port does not exist that is not `OPTIONAL`.
        """
        system = builder.GetSubsystemByName

        def is_absent(name: str, port: str, kind: str) -> bool:
            has_port = getattr(system(name), f"Has{kind}Port")
            return (name, port) in OPTIONAL and not has_port(port)

        for source, output, target, port in self.connections:
            if is_absent(source, output, "Output") or is_absent(target, port, "Input"):
                continue
            builder.Connect(system(source).GetOutputPort(output), system(target).GetInputPort(port))
        exported: set[str] = set()
        for name, target, port in self.inputs:
            if is_absent(target, port, "Input"):
                continue
            if name in exported:
                builder.ConnectInput(name, system(target).GetInputPort(port))
            else:
                builder.ExportInput(system(target).GetInputPort(port), name)
                exported.add(name)
        for source, output, name in self.outputs:
            if is_absent(source, output, "Output"):
                continue
            builder.ExportOutput(system(source).GetOutputPort(output), name)

    def build(self, builder: DiagramBuilder, name: str) -> Diagram:
        """Applies these rows, and returns the diagram of the builder's systems by its name."""
        self.apply(builder)
        diagram = builder.Build()
        diagram.set_name(name)
        return diagram


class Rate(NamedTuple):
    """Periodic events that several systems have in common.

    Attributes:
        systems: Their names; a scenario may have only some of them.
        period: Key of the scenario, in its section `rates` if the name has no dot.
        offset_steps: Offset from the multiples of the period, in steps of the plant.
        kind: `discrete` or `unrestricted`; at one instant Drake runs unrestricted updates first.
    """

    systems: tuple[str, ...]
    period: str
    offset_steps: float = 0.0
    kind: str = "discrete"
