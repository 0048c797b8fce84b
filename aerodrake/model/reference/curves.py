"""Reference curves of all kinds that a scenario can name."""

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from aerodrake.model.reference.closed_curves import CloverCurve, FigureEightCurve, LissajousCurve
from aerodrake.model.reference.reference_curve import Motion, ReferenceCurve, path_diameter
from aerodrake.model.reference.smoothing import smooth_waypoints
from aerodrake.model.reference.waypoints import interpolate_waypoints, read_waypoints
from aerodrake.scenario import references
from aerodrake.support.arguments import Vector3, checked
from aerodrake.support.errors import BadInput
from aerodrake.support.files import locate


class HoverCurve(ReferenceCurve):
    """Stays at `start` (3,) m."""

    diameter_m = 0.0

    def __init__(self, config: references.Hover, start: np.ndarray):
        self._start = start

    def _move(self, times: np.ndarray) -> Motion:
        return np.tile(self._start, (len(times), 1)), np.zeros((len(times), 3))


class MovingTargetCurve(ReferenceCurve):
    """p = target + height z + velocity t, the paper's second experiment.

    It does not begin at `start` (3,) m: the end-effector has to catch up. Its extent is not
    known in advance, hence its infinite diameter.
    """

    diameter_m = math.inf

    def __init__(self, config: references.MovingTarget, start: np.ndarray):
        self._origin = np.add(config.target_m, [0.0, 0.0, config.height_m])
        self._velocity = np.array(config.velocity_m_s)

    def _move(self, times: np.ndarray) -> Motion:
        p = self._origin + np.outer(times, self._velocity)
        return p, np.tile(self._velocity, (len(times), 1))


class WaypointCurve(ReferenceCurve):
    """Smooth path through the points of a file, or near rounded ones, whatever `start` (3,) m is.

    Outside the file's times it stays at the first or last point.

    Raises:
        BadInput: if the file cannot be used.
    """

    def __init__(self, config: references.Waypoints, start: np.ndarray):
        path = locate(config.file)
        self._times, points = read_waypoints(path)
        try:
            self._position = (
                smooth_waypoints(self._times, points, config.rounding_m)
                if config.rounding_m
                else interpolate_waypoints(self._times, points)
            )
        except ValueError as error:
            raise BadInput(path, "", str(error)) from None
        self._velocity = self._position.derivative()

    @cached_property
    def diameter_m(self) -> float:
        """d_g, in m, of samples between the first and the last point."""
        segments = len(self._times) - 1
        samples = segments * max(4, 4096 // segments)
        row = np.linspace(0, segments, samples + 1)
        times = np.interp(row, np.arange(segments + 1), self._times)
        return path_diameter(lambda t: self._move(t)[0], times)

    def _move(self, times: np.ndarray) -> Motion:
        return self._position.vector_values(times).T, self._velocity.vector_values(times).T


CURVES: dict[type, Callable[..., ReferenceCurve]] = {
    references.Hover: HoverCurve,
    references.Clover: CloverCurve,
    references.FigureEight: FigureEightCurve,
    references.Lissajous: LissajousCurve,
    references.MovingTarget: MovingTargetCurve,
    references.Waypoints: WaypointCurve,
}


@checked
def make_reference(config: references.Reference, start: Vector3) -> ReferenceCurve:
    """Returns the curve that a scenario's reference section describes.

    Args:
        config: The section.
        start: (3,) m, initial position of the end-effector in the world, where
            closed curves begin.

    Raises:
        BadInput: if the section names a file that cannot be used.
    """
    return CURVES[type(config)](config, np.array(start, dtype=float))
