"""Desired directions of the tool's axis over time, as unit vectors in the world frame.

Times are reference times in s. Before 0 the direction is that at 0.
"""

import math

import numpy as np

from aerodrake.model.reference.reference_curve import Motion, TimedPath
from aerodrake.model.reference.waypoints import interpolate_waypoints, read_waypoints
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import AxisAlong, FixedAxis, Orientation, OrientationOff
from aerodrake.scenario.references import SHORTEST_AXIS
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.support.files import locate

COLUMNS = {"t": ("s", 0.0, 1e5), **dict.fromkeys(("ax", "ay", "az"), ("1", -1000.0, 1000.0))}
"""Unit and closed range of each column of a file of directions."""

FARTHEST_RAD = math.radians(90)
"""Largest angle between consecutive rows of a path of directions."""

FARTHEST_START_RAD = math.radians(120)
"""Largest angle between the tool's axis and its desired direction at reference time 0."""


class Direction(TimedPath):
    """Desired direction d of the tool's axis over reference time, and d' in 1/s."""


class FixedDirection(Direction):
    """Constant direction."""

    def __init__(self, config: FixedAxis):
        self._d = np.array(config.axis) / np.linalg.norm(config.axis)

    def _move(self, times: np.ndarray) -> Motion:
        return np.tile(self._d, (len(times), 1)), np.zeros((len(times), 3))


class DirectionPath(Direction):
    """Smooth path through the directions of a file, at rest at both ends.

    Its rows are scaled to length 1 and interpolated as waypoints are; interpolated vectors
    are scaled to length 1 again. Outside the file's times the first or last row applies.

    Raises:
        BadInput: if the file cannot be used, has a row without a direction, or
            consecutive rows more than `FARTHEST_RAD` apart.
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

    def _move(self, times: np.ndarray) -> Motion:
        w, rate = self._path.vector_values(times).T, self._derivative.vector_values(times).T
        length = np.linalg.norm(w, axis=1, keepdims=True)
        d = w / length
        return d, (rate - d * np.sum(d * rate, axis=1, keepdims=True)) / length


@checked
def make_direction(config: Orientation) -> Direction | None:
    """Returns the directions of a scenario's orientation section; None if it is off.

    Raises:
        BadInput: if the section names a file that cannot be used.
    """
    if isinstance(config, OrientationOff):
        return None
    return FixedDirection(config) if isinstance(config, FixedAxis) else DirectionPath(config)


def check_start(direction: Direction, vehicle: VehicleModel) -> None:
    """Raises ScenarioError if the tool's axis is over `FARTHEST_START_RAD` from d at time 0.

    If the two were opposite in the working configuration, the sense of rotation would be
    undefined.
    """
    d = direction.evaluate(np.zeros(1))[0][0]
    angle = math.acos(np.clip(vehicle.tool_axis @ d, -1.0, 1.0))
    if angle > FARTHEST_START_RAD:
        raise ScenarioError(
            vehicle.source,
            "orientation",
            f"expected an initial direction within {math.degrees(FARTHEST_START_RAD):.0f} deg of "
            f"the tool's axis in vehicle.working_rad, got {math.degrees(angle):.1f} deg",
        )
