"""Discrete state of a LeafSystem in named groups."""

from collections.abc import Callable, Iterator
from typing import Any, Generic, TypeVar

import numpy as np
from pydrake.systems.framework import Context, DiscreteStateIndex, DiscreteValues, LeafSystem

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
        self.groups: dict[str, DiscreteStateIndex] = {
            name: system.DeclareDiscreteState(np.ravel(value).astype(float))
            for name, value in _leaves(initial)
        }
        # As plain integers: half the time of an access, of which there are many at each tick.
        self._indices = [int(group) for group in self.groups.values()]
        self._kinds = [(type(value), np.shape(value)) for _, value in _leaves(initial)]

    def read(self, context: Context) -> State:
        """Returns a copy of the state in a Context, in the shapes and types of the defaults."""
        value_of = context.get_discrete_state().value
        return self._state_of([value_of(index) for index in self._indices])

    def write(self, discrete: DiscreteValues, state: State) -> None:
        """Sets all groups, as in a discrete update."""
        view_of = discrete.get_mutable_value
        _fill([view_of(index) for index in self._indices], state)

    def update(self, discrete: DiscreteValues, step: Callable[[State], State]) -> None:
        """Replaces the state x by step(x), in the time of one `write`.

        Args:
            discrete: Of a discrete update, which begins as a copy of the Context's.
            step: Returns the next state.
        """
        view_of = discrete.get_mutable_value
        views = [view_of(index) for index in self._indices]
        _fill(views, step(self._state_of(views)))

    def _state_of(self, views: list[np.ndarray]) -> State:
        values = [
            (view.copy() if len(shape) == 1 else view.reshape(shape).copy())
            if kind is np.ndarray
            else kind(view[0])
            for view, (kind, shape) in zip(views, self._kinds, strict=True)
        ]
        return _nested(self._initial, iter(values))


def _fill(views: list[np.ndarray], state: tuple) -> None:
    for view, value in zip(views, _flat(state), strict=True):
        view[:] = value.ravel() if isinstance(value, np.ndarray) else value


def _flat(state: tuple) -> list[Any]:
    values = []
    for value in state:
        if isinstance(value, tuple):
            values += _flat(value)
        else:
            values.append(value)
    return values


def _nested(example: tuple, values: Iterator[Any]) -> Any:
    """Returns values in the nested NamedTuples of an example."""
    fields = [_nested(x, values) if isinstance(x, tuple) else next(values) for x in example]
    return type(example)(*fields)


def _leaves(state: tuple, prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yields the dotted name and the value of each field that is no NamedTuple."""
    for name, value in zip(state._fields, state, strict=True):
        if isinstance(value, tuple):
            yield from _leaves(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value
