"""Coordinates of the discrete state of a diagram."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from pydrake.systems.framework import Diagram, DiscreteValues, System

from aerodrake.model.vehicle.rotation import conjugate, product, rotation_vector, turned
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.station import leaf_systems
from aerodrake.systems.named_state import group_names

BASE = ("roll", "pitch", "yaw", "x", "y", "z")
"""Coordinates of the base, before those of the joints; those of the rates follow."""

PLANT, RATE = "plant.", "_rate"
"""Prefix of the names of the plant's coordinates, and suffix of those that are rates."""


@dataclass(frozen=True)
class StateGroup:
    """One group of the discrete state, in coordinates without constraints.

    Attributes:
        index: Of the group in the diagram's discrete state.
        system: Name of the system that has it; `plant` for a part of the plant.
        name: Name of the group.
        coordinates: Name of each coordinate.
        is_vehicle: True for a `VehicleState`, whose attitude has three coordinates: a rotation
            vector in the base frame.
    """

    index: int
    system: str
    name: str
    coordinates: tuple[str, ...]
    is_vehicle: bool

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    def perturb(self, values: DiscreteValues, step: np.ndarray) -> None:
        """Adds a step (`size`,) to the group's values."""
        x = values.get_mutable_value(self.index)
        if self.is_vehicle:
            x[:4], x[4:] = turned(x[:4].copy(), step[:3]), x[4:] + step[3:]
        else:
            x += step

    def difference(self, values: np.ndarray, nominal: np.ndarray) -> np.ndarray:
        """Returns the step (`size`,) from nominal values to others."""
        if self.is_vehicle:
            turn = rotation_vector(product(conjugate(nominal[:4].copy()), values[:4].copy()))
            return np.concatenate([turn, values[4:] - nominal[4:]])
        return values - nominal


@dataclass(frozen=True)
class StateCoordinates:
    """Coordinates of several groups of the discrete state, in a row.

    Attributes:
        groups: The groups.
    """

    groups: tuple[StateGroup, ...]

    @classmethod
    def of(cls, diagram: Diagram, values: DiscreteValues, joints: Sequence[str]) -> Self:
        """Returns the coordinates of a diagram's whole state.

        Args:
            diagram: The diagram.
            values: Its state. A group of the size of a `VehicleState` that begins with a unit
                quaternion is one.
            joints: Names of the n joints.
        """
        positions = (*BASE, *joints)
        vehicle = (*positions, *(f"{name}{RATE}" for name in positions))
        groups: list[StateGroup] = []
        for leaf in leaf_systems(diagram):
            own, system = group_names(leaf), _name(leaf)
            count = leaf.CreateDefaultContext().num_discrete_state_groups()
            for i in range(count):
                index, name = len(groups), own.get(i, "" if count == 1 else f"{i}")
                x = values.value(index)
                is_vehicle = len(x) == VehicleState.size(len(joints))
                is_vehicle = is_vehicle and abs(np.linalg.norm(x[:4]) - 1) < 0.01
                prefix = ".".join(part for part in (system, name) if part)
                if is_vehicle:
                    names = tuple(f"{prefix}.{coordinate}" for coordinate in vehicle)
                elif len(x) == 1:
                    names = (prefix,)
                else:
                    names = tuple(f"{prefix}[{k}]" for k in range(len(x)))
                groups.append(StateGroup(index, system, name, names, is_vehicle))
        return cls(tuple(groups))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of all coordinates."""
        return tuple(name for group in self.groups for name in group.coordinates)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Coordinates of each group."""
        ends = np.cumsum([0, *(group.size for group in self.groups)])
        return tuple(slice(int(a), int(b)) for a, b in zip(ends[:-1], ends[1:], strict=True))

    def of_group(self, system: str, name: str) -> slice:
        """Returns the coordinates of one group."""
        keys = [(group.system, group.name) for group in self.groups]
        return self.slices[keys.index((system, name))]


def _name(leaf: System) -> str:
    """Returns the name of a leaf system; that of the plant for the system in it with its state."""
    is_plant = "plant" in leaf.GetSystemPathname().split("::")
    return "plant" if is_plant else leaf.get_name()
