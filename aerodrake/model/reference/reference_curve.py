"""Base class of the end-effector's reference curves, and the diameter of a curve.

Times are reference times in s: 0 is the end of the initial hover. Positions and velocities are
p_E,d and its derivative in the world frame, z up.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
from scipy.spatial.distance import cdist

Motion = tuple[np.ndarray, np.ndarray]
"""Values (T, 3) of a vector, a position in m or a direction, and their derivatives (T, 3)."""


class TimedPath(ABC):
    """Vector in the world frame as a function of reference time, constant before time 0."""

    def evaluate(self, times: np.ndarray) -> Motion:
        """Returns values (T, 3) and derivatives (T, 3) at reference times (T,) in s.

        Before reference time 0 the value is that at 0, and the derivative is zero.
        """
        times = np.asarray(times, dtype=float)
        p, v = self._move(np.maximum(times, 0.0))
        return p, np.where(times[:, None] < 0.0, 0.0, v)

    @abstractmethod
    def _move(self, times: np.ndarray) -> Motion:
        """Implements `evaluate` for times (T,) >= 0."""


class ReferenceCurve(TimedPath):
    """Desired position of the end-effector in m over reference time, and its velocity in m/s."""

    @property
    @abstractmethod
    def diameter_m(self) -> float:
        """d_g, the largest distance between two points of the target trajectory, in m."""

    @property
    def lap(self) -> tuple[float, float] | None:
        """Start and end in s of one whole lap after the smooth start; None without laps."""
        return None


def hover_then_follow(curve: ReferenceCurve, start: np.ndarray, times: np.ndarray) -> Motion:
    """Returns a flight's reference at times (T,): `start` (3,) m before 0, then the curve."""
    p, v = curve.evaluate(times)
    return np.where(times[:, None] < 0.0, start, p), v


def path_diameter(position: Callable[[np.ndarray], np.ndarray], times: np.ndarray) -> float:
    """Returns the largest distance between two points of a path, in m.

    The farthest pair of samples is refined three times, each time between its neighbours and
    on a grid 32 times as fine. The error of the samples decreases with the square of their
    spacing in time; the error of the refinement is 1e-9 of it.

    Args:
        position: Maps times (T,) in s to points (T, 3) in m.
        times: (T,) s, ascending; dense enough to separate the path's turns.
    """
    a = b = times
    i, j = farthest_pair(position(times))
    for _ in range(3):
        a, b = _between_neighbours(a, i), _between_neighbours(b, j)
        distances = cdist(position(a), position(b))
        i, j = np.unravel_index(distances.argmax(), distances.shape)
    return float(distances[i, j])


def farthest_pair(points: np.ndarray) -> tuple[int, int]:
    """Returns the indices of the two points (M, 3) that are farthest apart, exactly.

    Points are visited from the outermost inwards. Two points at radii r and s from the middle
    are at most r + s apart, which excludes most pairs without computing their distance.
    """
    radius = np.linalg.norm(points - (points.min(axis=0) + points.max(axis=0)) / 2, axis=1)
    order = np.argsort(-radius)
    points, radius = points[order], radius[order]
    best, pair, block = -1.0, (0, 0), 64
    for first in range(0, len(points), block):
        end = np.searchsorted(-radius, radius[first] - best)
        if end <= first:
            break
        distances = cdist(points[first : first + block], points[first:end])
        i, j = np.unravel_index(distances.argmax(), distances.shape)
        if distances[i, j] > best:
            best, pair = distances[i, j], (int(order[first + i]), int(order[first + j]))
    return pair


def _between_neighbours(times: np.ndarray, i: int) -> np.ndarray:
    return np.linspace(times[max(i - 1, 0)], times[min(i + 1, len(times) - 1)], 65)
