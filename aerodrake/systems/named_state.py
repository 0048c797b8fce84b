"""Discrete state of a LeafSystem in named groups."""

from collections.abc import Iterator
from typing import Any, Generic, TypeVar

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    LeafSystem,
    System,
)

State = TypeVar("State", bound=tuple)


class NamedState(Generic[State]):
    """The discrete state of a LeafSystem, one group for each field of a NamedTuple.

    A field may be a NamedTuple itself: its fields have a group each.

    Attributes:
        groups: Index of each field's group, for `DeclareStateOutputPort`; of a nested
            field by its dotted name.

    Args:
        system: The system that declares the groups, in the order of the fields.
        initial: The default value of each field: a float array of any shape, a number, or
            a NamedTuple of them.
    """

    def __init__(self, system: LeafSystem, initial: State):
        self._initial = initial
        self.groups: dict[str, DiscreteStateIndex] = {}
        # Plain integers as indices halve the time of an access; each tick makes many.
        self._fields: list[tuple[int, tuple[int, ...], type]] = []
        for name, value in _leaves(initial):
            group = system.DeclareDiscreteState(np.ravel(value).astype(float))
            self.groups[name] = group
            self._fields.append((int(group), np.shape(value), type(value)))

    def read(self, source: Context | DiscreteValues) -> State:
        """Returns a copy of the state, in the shapes and types of the defaults.

        Args:
            source: A Context, or the values that several updates of one instant change in turn.
        """
        values = source if isinstance(source, DiscreteValues) else source.get_discrete_state()
        value_of = values.value
        parts = (
            value_of(index).reshape(shape).copy() if shape else kind(value_of(index)[0])
            for index, shape, kind in self._fields
        )
        return _nested(self._initial, parts)

    def write(self, discrete: DiscreteValues, state: State) -> None:
        """Sets all groups, as in a discrete update."""
        view_of = discrete.get_mutable_value
        for (index, shape, _), (_, value) in zip(self._fields, _leaves(state), strict=True):
            view_of(index).reshape(shape)[...] = value


def group_names(system: System) -> dict[int, str]:
    """Returns the names of a system's discrete groups that belong to its `NamedState`s, by index.

    Args:
        system: A leaf system; its attributes are searched, tuples included.
    """
    values = vars(system).values() if isinstance(system, LeafSystem) else ()
    states = (
        state
        for value in values
        for state in (value if isinstance(value, tuple) else (value,))
        if isinstance(state, NamedState)
    )
    return {int(index): name for state in states for name, index in state.groups.items()}


def _leaves(state: tuple, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yields the dotted name and the value of each field that is no NamedTuple."""
    for name, value in zip(state._fields, state, strict=True):
        if isinstance(value, tuple):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


def _nested(example: tuple, values: Iterator[Any]) -> Any:
    """Returns values in the nested NamedTuples of an example."""
    return example._make(
        _nested(part, values) if isinstance(part, tuple) else next(values) for part in example
    )
