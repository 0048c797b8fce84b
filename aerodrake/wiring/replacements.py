"""Systems of a person's own in the place of ours, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from pydrake.systems.framework import (
    Diagram,
    DiagramBuilder,
    InputPort,
    OutputPort,
    PortDataType,
    System,
)

from aerodrake.support.errors import BadInput, nearest

Replacement = Callable[[System], System]
"""Makes a system that takes the place of one of ours, which it is given.

It has every port of ours, by name, size and type; it may have outputs beside them.
Rates and state are its own.
"""

FIXED = frozenset({"plant", "scene_graph"})
"""Whose bodies and geometry others read beyond any port: these are always ours."""


class Replacements:
    """Which systems are not ours: for `make_station`, `make_coordinator`, `make_closed_loop`
    and `Flight`.

    Names are those on the wiring pages and in `diagrams/graphs`, of systems and of diagrams of
    them; a side of the closed loop that is made alone takes those of its own.

    Args:
        by_name: What makes the system of each name.
    """

    def __init__(self, by_name: Mapping[str, Replacement] | None = None):
        self._by_name = dict(by_name or {})
        self._met: set[str] = set()
        self._is_part = False

    def builder(self) -> DiagramBuilder:
        """Adds these systems where ours of their names are added; refuses to build without one."""
        return _ReplacingBuilder(self)

    def part(self) -> Replacements:
        """The same for a diagram inside of another, in which systems may be as well."""
        part = Replacements(self._by_name)
        part._met, part._is_part = self._met, True
        return part

    def instead_of(self, name: str, ours: System) -> System:
        """The system to be added by a name: ours, unless another takes its place.

        Raises:
            BadInput: if that has not the ports of ours.
        """
        if name in FIXED:
            return ours
        self._met.add(name)
        if name not in self._by_name:
            return ours
        make = self._by_name[name]
        if not callable(make):
            message = "expected a function that is given ours and returns a system, got"
            raise BadInput("replacements", name, f"{message} {type(make).__name__}")
        theirs = make(ours)
        if not isinstance(theirs, System):
            raise BadInput("replacements", name, f"expected a system, got {type(theirs).__name__}")
        if theirs is not ours and theirs.GetSystemPathname().count("::") > 1:
            raise BadInput("replacements", name, "expected a new system, got one of a diagram")
        for kind, ports_of in (("an input", _inputs), ("an output", _outputs)):
            have = ports_of(theirs)
            for port, wanted in ports_of(ours).items():
                if have.get(port) != wanted:
                    got = have.get(port) or ", ".join(have) or "none"
                    raise BadInput(
                        "replacements",
                        name,
                        f"expected {kind} port '{port}' of {wanted}, got {got}",
                    )
        for port in _inputs(theirs).keys() - _inputs(ours).keys():
            raise BadInput("replacements", name, f"nothing is there for its input port '{port}'")
        theirs.set_name(name)
        return theirs

    def check_met(self) -> None:
        """Raises BadInput if a name is of none that was added so far and can be replaced."""
        for name in sorted(self._by_name.keys() - self._met) if not self._is_part else ():
            message = f"no such system that can be replaced; {nearest(name, self._met)}"
            raise BadInput("replacements", name, message)


class _ReplacingBuilder(DiagramBuilder):
    def __init__(self, replacements: Replacements):
        super().__init__()
        self._replacements = replacements

    def AddSystem(self, system: System) -> System:
        return super().AddSystem(self._replacements.instead_of(system.get_name(), system))

    def AddNamedSystem(self, name: str, system: System) -> System:
        return super().AddNamedSystem(name, self._replacements.instead_of(name, system))

    def Build(self) -> Diagram:
        self._replacements.check_met()
        return super().Build()


def _inputs(system: System) -> dict[str, str]:
    ports = map(system.get_input_port, range(system.num_input_ports()))
    return {port.get_name(): _size(port) for port in ports}


def _outputs(system: System) -> dict[str, str]:
    ports = map(system.get_output_port, range(system.num_output_ports()))
    return {port.get_name(): _size(port) for port in ports}


def _size(port: InputPort | OutputPort) -> str:
    is_vector = port.get_data_type() == PortDataType.kVectorValued
    return f"size {port.size()}" if is_vector else "an abstract value"
