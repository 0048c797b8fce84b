"""Discrete state of a LeafSystem in named groups."""

from __future__ import annotations

from typing import Generic, TypeVar

import numpy as np
from pydrake.systems.framework import Context, DiscreteStateIndex, DiscreteValues, LeafSystem

State = TypeVar("State", bound=tuple)


class NamedState(Generic[State]):
    """The discrete state of a LeafSystem, one group for each field of a NamedTuple.

    Attributes:
        groups: Index of each field's group, for `DeclareStateOutputPort`.

    Args:
        system: The system that declares the groups, in the order of the fields.
        initial: The default value of each field: a float array of any shape, or a number.
    """

    def __init__(self, system: LeafSystem, initial: State):
        self._kind = type(initial)
        self._defaults = initial
        self.groups: dict[str, DiscreteStateIndex] = {
            name: system.DeclareDiscreteState(np.ravel(value).astype(float))
            for name, value in zip(initial._fields, initial, strict=True)
        }

    def read(self, context: Context) -> State:
        """Returns a copy of the state in a Context, in the shapes and types of the defaults."""
        values = context.get_discrete_state()
        fields = []
        for group, default in zip(self.groups.values(), self._defaults, strict=True):
            value = values.value(group)
            is_array = isinstance(default, np.ndarray)
            fields.append(
                value.reshape(default.shape).copy() if is_array else type(default)(value[0])
            )
        return self._kind(*fields)

    def write(self, discrete: DiscreteValues, state: State) -> None:
        """Sets all groups, as in a discrete update."""
        for group, value in zip(self.groups.values(), state, strict=True):
            discrete.set_value(group, np.ravel(value))
