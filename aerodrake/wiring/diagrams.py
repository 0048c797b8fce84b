"""Traversal of diagrams."""

from collections.abc import Iterator

from pydrake.systems.framework import Diagram, System


def leaf_systems(system: System) -> Iterator[System]:
    """Yields the leaf systems of a diagram at any depth; a leaf system yields itself."""
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from leaf_systems(inner)
    else:
        yield system
