"""Where the tool is to point over time: unit vectors in the world frame.

Times are reference times in s. Before 0 the direction is that at 0.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np

from aerodrake.model.reference.waypoints import interpolate_waypoints, read_waypoints
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import AxisAlong, FixedAxis, Orientation, OrientationOff
from aerodrake.scenario.rules import SHORTEST_AXIS
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.support.files import locate

COLUMNS = {
    "t": ("s", 0.0, 1e5),
    "ax": ("1", -1000.0, 1000.0),
    "ay": ("1", -1000.0, 1000.0),
    "az": ("1", -1000.0, 1000.0),
}
"""Unit and closed range of each column of a file of directions."""

FARTHEST_RAD = math.radians(90)
"""The most by which a path of directions may turn from one row to the next."""

FARTHEST_START_RAD = math.radians(120)
"""The most by which the tool may have to turn before it points where it is to point."""


class Direction(ABC):
    """The direction d that the tool is to have."""

    def evaluate(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """d (T, 3) and d' (T, 3) in 1/s at reference times (T,) in s."""
        times = np.asarray(times, dtype=float)
        d, rate = self._turn(np.maximum(times, 0.0))
        return d, np.where(times[:, None] < 0.0, 0.0, rate)

    @abstractmethod
    def _turn(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As `evaluate`, for times (T,) >= 0."""


class FixedDirection(Direction):
    """Always the same."""

    def __init__(self, config: FixedAxis):
        self._d = np.array(config.axis) / np.linalg.norm(config.axis)

    def _turn(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.tile(self._d, (len(times), 1)), np.zeros((len(times), 3))


class DirectionPath(Direction):
    """The smooth path of directions through those of a file, at rest at both ends.

    Its rows, scaled to length 1, are joined as waypoints are, and what is between
    them is scaled to length 1 again; outside its times the ends hold.

    Raises:
        BadInput: if the file cannot be used, has a row without a direction, or
            two that follow each other more than `FARTHEST_RAD` apart.
    """

    def __init__(self, config: AxisAlong):
        path = locate(config.file)
        times, rows = read_waypoints(path, COLUMNS)
        lengths = np.linalg.norm(rows, axis=1)
        for t in times[lengths < SHORTEST_AXIS]:
            raise BadInput(
                path, "", f"t = {t:g} s: expected ax, ay, az of length {SHORTEST_AXIS:g} or more"
            )
        d = rows / lengths[:, None]
        turns = np.arccos(np.clip(np.sum(d[1:] * d[:-1], axis=1), -1.0, 1.0))
        for t, turn in zip(times, turns, strict=False):
            if turn > FARTHEST_RAD + 1e-6:
                raise BadInput(
                    path,
                    "",
                    f"after t = {t:g} s: expected turns of {math.degrees(FARTHEST_RAD):.0f} deg "
                    f"or less from row to row, got {math.degrees(turn):.1f} deg",
                )
        self._path = interpolate_waypoints(times, d)
        self._derivative = self._path.derivative()

    def _turn(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w, rate = self._path.vector_values(times).T, self._derivative.vector_values(times).T
        length = np.linalg.norm(w, axis=1, keepdims=True)
        d = w / length
        return d, (rate - d * np.sum(d * rate, axis=1, keepdims=True)) / length


def make_direction(config: Orientation) -> Direction | None:
    """The directions that a scenario's orientation section describes; None where it is off.

    Raises:
        BadInput: if the section names a file that cannot be used.
    """
    if isinstance(config, OrientationOff):
        return None
    return FixedDirection(config) if isinstance(config, FixedAxis) else DirectionPath(config)


def check_start(direction: Direction, vehicle: VehicleModel) -> None:
    """Refuses a direction that the tool, as it is in the working configuration, would not turn to.

    Straight away from where it points, nothing tells it which way to turn.

    Raises:
        ScenarioError: if it is more than `FARTHEST_START_RAD` away at reference time 0.
    """
    d = direction.evaluate(np.zeros(1))[0][0]
    angle = math.acos(np.clip(vehicle.tool_axis @ d, -1.0, 1.0))
    if angle > FARTHEST_START_RAD:
        raise ScenarioError(
            vehicle.source,
            "orientation",
            f"expected a direction at first within {math.degrees(FARTHEST_START_RAD):.0f} deg of "
            f"the tool's in vehicle.working_rad, got {math.degrees(angle):.1f} deg",
        )
