"""Replacement of systems in station and coordinator by the user's own, by name."""

from collections.abc import Callable, Mapping
from typing import Self

from pydrake.systems.framework import Diagram, DiagramBuilder, PortDataType, System

from aerodrake.support.errors import BadInput, nearest
from aerodrake.wiring.table import OPTIONAL

Replacement = Callable[[System], System]
"""Function that receives the default system and returns the system to use instead.

The result must have every port of the default one, by name, size and type, but those in
`aerodrake.wiring.table.OPTIONAL`. It may have more
outputs. Rates and state are its own.
"""


class Replacements:
    """Replacements by name, an argument of `make_station`, `make_coordinator`,
    `make_closed_loop` and `FlightSimulation`.

    Names are those of systems and sub-diagrams in the wiring tables and in `diagrams/graphs`.
    Station and coordinator, made alone, accept the names of their own systems.

    Args:
        by_name: Replacement of the system of each name.
    """

    def __init__(self, by_name: Mapping[str, Replacement] | None = None):
        self._by_name = dict(by_name or {})
        self._used: set[str] = set()
        self._is_part = False

    def builder(self) -> DiagramBuilder:
        """Makes a DiagramBuilder that replaces systems as they are added.

        Its `Build` raises BadInput as `check_used` does.
        """
        return _ReplacingBuilder(self)

    def part(self) -> Self:
        """Returns the same replacements for a sub-diagram, which need not contain all of them."""
        part = Replacements(self._by_name)
        part._used, part._is_part = self._used, True
        return part

    def instead_of(self, name: str, ours: System) -> System:
        """Returns the replacement for the system of a name, or `ours` without one.

        Raises:
            BadInput: if the replacement is no new system, or its ports do not match.
        """
        self._used.add(name)
        if name not in self._by_name:
            return ours
        make = self._by_name[name]
        if not callable(make):
            problem = "expected a function from a system to a system, got"
            raise BadInput("replacements", name, f"{problem} {type(make).__name__}")
        theirs = make(ours)
        if not isinstance(theirs, System):
            raise BadInput("replacements", name, f"expected a system, got {type(theirs).__name__}")
        if theirs is not ours and theirs.GetSystemPathname().count("::") > 1:
            raise BadInput("replacements", name, "expected a new system, got one of a diagram")
        known = _ports(ours, "input")
        for port in _ports(theirs, "input"):
            if port not in known:
                problem = f"no signal for its input port '{port}'; {nearest(port, known)}"
                raise BadInput("replacements", name, problem)
        for kind in ("input", "output"):
            have = _ports(theirs, kind)
            for port, expected in _ports(ours, kind).items():
                is_absent = port not in have and (name, port) in OPTIONAL
                if have.get(port) != expected and not is_absent:
                    problem = f"expected an {kind} port '{port}' of {expected}"
                    got = f", got {have[port]}" if port in have else f"; {nearest(port, have)}"
                    raise BadInput("replacements", name, problem + got)
        theirs.set_name(name)
        return theirs

    def check_used(self) -> None:
        """Raises BadInput if a name is not that of a replaceable system added so far."""
        for name in sorted(self._by_name.keys() - self._used) if not self._is_part else ():
            problem = f"no such system that can be replaced; {nearest(name, self._used)}"
            raise BadInput("replacements", name, problem)


class _ReplacingBuilder(DiagramBuilder):
    def __init__(self, replacements: Replacements):
        super().__init__()
        self._replacements = replacements

    def AddSystem(self, system: System) -> System:
        return super().AddSystem(self._replacements.instead_of(system.get_name(), system))

    def AddNamedSystem(self, name: str, system: System) -> System:
        return super().AddNamedSystem(name, self._replacements.instead_of(name, system))

    def Build(self) -> Diagram:
        self._replacements.check_used()
        return super().Build()


def _ports(system: System, kind: str) -> dict[str, str]:
    """Returns the sizes of a system's `input` or `output` ports by name, for messages."""
    sizes = {}
    for i in range(getattr(system, f"num_{kind}_ports")()):
        port = getattr(system, f"get_{kind}_port")(i)
        is_vector = port.get_data_type() == PortDataType.kVectorValued
        sizes[port.get_name()] = f"size {port.size()}" if is_vector else "an abstract value"
    return sizes
