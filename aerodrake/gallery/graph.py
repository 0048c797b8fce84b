"""Boxes and arrows of a drawing of a diagram or system, in the order of the signals.

They depend only on the wiring: a diagram gives the same drawing in every process, so that it can
be committed and compared. `system` is a diagram or a leaf system; `depth` is the number of levels
of diagrams to open, and 0 draws one box.
"""

import re
from collections import defaultdict
from collections.abc import Collection, Iterator
from dataclasses import dataclass

from pydrake.systems.framework import Diagram, System

from aerodrake.gallery.ports import (
    Port,
    box_output,
    connections,
    input_ports,
    is_default,
    opens,
    output_ports,
    size,
    targets,
)
from aerodrake.gallery.signal_order import signal_order

INPUTS, OUTPUTS = "inputs", "outputs"
"""Boxes for the ports of an opened diagram."""


@dataclass(frozen=True)
class Box:
    """A box: a system, or ports of the drawn system.

    Attributes:
        id: A word, different for each box of a drawing.
        label: Text in the box.
        system: The system; None for ports.
        rank: Row of the box, 0 at the top; of an opened diagram, of its uppermost boxes.
        inside: Boxes of an opened diagram in signal order; empty for all others.
    """

    id: str
    label: str
    system: System | None
    rank: int
    inside: tuple["Box", ...] = ()

    @property
    def leaves(self) -> tuple["Box", ...]:
        """The boxes in it, at any depth, that contain no others; for such a box, itself."""
        return tuple(leaf for box in self.inside for leaf in box.leaves) or (self,)


@dataclass(frozen=True)
class Arrow:
    """All signals from one box to another.

    Attributes:
        source, target: Boxes that contain no others.
        signals: Names of the source's ports, or of the target's where the source has a default
            name such as `y0`; empty if both have.
    """

    source: Box
    target: Box
    signals: tuple[str, ...]

    @property
    def is_feedback(self) -> bool:
        """True if the target is above the source, or is the source."""
        return self.target.rank <= self.source.rank


@dataclass(frozen=True)
class Graph:
    """A drawing.

    Attributes:
        boxes: Boxes in signal order, which contain others if they are opened.
        arrows: Arrows in the order of their ends.
    """

    boxes: tuple[Box, ...]
    arrows: tuple[Arrow, ...]

    @property
    def leaves(self) -> tuple[Box, ...]:
        """All boxes that contain no others, in signal order."""
        return tuple(leaf for box in self.boxes for leaf in box.leaves)


def graph_of(system: System, depth: int, without: Collection[str] = ()) -> Graph:
    """Returns the drawing of a system, whose subsystems of some names are left out.

    An opened diagram is drawn with its systems, in signal order, and a box each for its inputs
    and its outputs. A closed loop, which has no inputs, is drawn without outputs. Any other
    system is one box between its ports. Ports of size zero are left out.
    """
    ids = _Ids()
    if not opens(system, depth):
        return _closed(system, ids)
    top = _opened(system, depth, 1, ids, without)
    box_of = {leaf.system.GetSystemPathname(): leaf for leaf in top.leaves}
    signals: dict[tuple[Box, Box], set[str]] = defaultdict(set)

    def box(port: Port) -> Box | None:
        return box_of.get(port.get_system().GetSystemPathname())

    for source, target in connections(system, depth):
        if box(source) and box(target):
            signals[box(source), box(target)].add(_signal(source, target))
    boxes = top.inside
    if inputs := input_ports(system):
        last_rank = max(leaf.rank for leaf in top.leaves)
        first = Box(ids.new(INPUTS), INPUTS, None, 0)
        last = Box(ids.new(OUTPUTS), OUTPUTS, None, last_rank + 1)
        boxes = (first, *boxes, last)
        for port in inputs:
            for target in targets(port, depth):
                signals[first, box(target)].add(_signal(port))
        for port in output_ports(system):
            signals[box(box_output(port, depth)), last].add(_signal(port))
    places = {leaf.id: i for i, leaf in enumerate(leaf for top in boxes for leaf in top.leaves)}
    arrows = [Arrow(*ends, tuple(sorted(names - {""}))) for ends, names in signals.items()]
    arrows.sort(key=lambda arrow: (places[arrow.source.id], places[arrow.target.id]))
    return Graph(boxes, tuple(arrows))


def label(system: System) -> str:
    """Returns the name of a system; that of its class if it has none."""
    name = system.get_name()
    # Drake's default names contain an address.
    return type(system).__name__ if not name or "@" in name else name


def systems_by_name(system: System) -> dict[str, System]:
    """Returns a system and, if it is a diagram, all systems in it, by name.

    Raises:
        ValueError: if two of them share a name, or one has no name.
    """
    systems: dict[str, System] = {}
    for inner in all_systems(system):
        name = inner.get_name()
        if not re.fullmatch(r"\w+", name) or name in systems:
            problem = f"two named '{name}'" if name in systems else f"'{name}'"
            raise ValueError(f"expected a different word as each system's name, got {problem}")
        systems[name] = inner
    return systems


def all_systems(system: System) -> Iterator[System]:
    """Yields a system and, if it is a diagram, all systems in it, diagrams before their own."""
    yield system
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from all_systems(inner)


def _closed(system: System, ids: "_Ids") -> Graph:
    inputs = tuple(_port(ids, "in", port, 0) for port in input_ports(system))
    box = Box(ids.new(label(system)), label(system), system, 1)
    outputs = tuple(_port(ids, "out", port, 2) for port in output_ports(system))
    arrows = [Arrow(port, box, ()) for port in inputs] + [Arrow(box, port, ()) for port in outputs]
    return Graph((*inputs, box, *outputs), tuple(arrows))


def _port(ids: "_Ids", side: str, port: Port, rank: int) -> Box:
    name = port.get_name()
    return Box(ids.new(f"{side}_{name}"), f"{name} ({size(port)})", None, rank)


def _opened(
    system: System, depth: int, rank: int, ids: "_Ids", without: Collection[str] = ()
) -> Box:
    """Returns the box of a system, whose uppermost boxes have the given rank."""
    word = ids.new(label(system))
    if not opens(system, depth):
        return Box(word, label(system), system, rank)
    systems = [inner for inner in system.GetSystems() if inner.get_name() not in without]
    signals = list(_signals(system, systems))
    joined = {frozenset((source, target)) for source, own in signals for target in own}
    inside: dict[int, Box] = {}
    for i in signal_order(signals, len(systems)):
        above = [inside[other] for other in inside if frozenset((i, other)) in joined]
        ranks = [leaf.rank for box in above for leaf in box.leaves]
        inside[i] = _opened(systems[i], depth - 1, max(ranks, default=rank - 1) + 1, ids)
    return Box(word, label(system), system, rank, tuple(inside.values()))


def _signals(diagram: Diagram, systems: list[System]) -> Iterator[tuple[int, frozenset[int]]]:
    """Yields source and targets of each signal between some systems of a diagram."""
    index = {inner.GetSystemPathname(): i for i, inner in enumerate(systems)}
    fed: dict[tuple[int, int], set[int]] = defaultdict(set)
    for (target, _), (source, port) in diagram.connection_map().items():
        ends = index.get(source.GetSystemPathname()), index.get(target.GetSystemPathname())
        if None not in ends:
            fed[ends[0], int(port)].add(ends[1])
    for (source, _), own in sorted(fed.items()):
        yield source, frozenset(own)


class _Ids:
    """Words that differ from each other."""

    def __init__(self) -> None:
        self._used: set[str] = set()

    def new(self, name: str) -> str:
        """Returns a word close to a name that has not been returned before."""
        word = unique = re.sub(r"\W+", "_", name)
        number = 1
        while unique in self._used:
            number += 1
            unique = f"{word}_{number}"
        self._used.add(unique)
        return unique


def _signal(*ports: Port) -> str:
    return next((port.get_name() for port in ports if not is_default(port.get_name())), "")
