"""The diameter of a path: the largest distance between two of its points."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.distance import cdist


def path_diameter(position: Callable[[np.ndarray], np.ndarray], times: np.ndarray) -> float:
    """The largest distance between two points of a path, in m.

    The farthest pair of samples is refined three times, each time between its
    neighbours and on a grid 32 times as fine. What the samples miss falls with
    the square of their distance in time; what the refined grids miss is 1e-9 of it.

    Args:
        position: Maps times (T,) in s to points (T, 3) in m.
        times: (T,) s, ascending; dense enough to tell the path's turns apart.
    """
    a = b = times
    points = position(times)
    i, j = farthest_pair(points)
    distance = float(np.linalg.norm(points[i] - points[j]))
    for _ in range(3):
        a, b = _between_neighbours(a, i), _between_neighbours(b, j)
        distances = cdist(position(a), position(b))
        i, j = np.unravel_index(distances.argmax(), distances.shape)
        distance = float(distances[i, j])
    return distance


def farthest_pair(points: np.ndarray) -> tuple[int, int]:
    """Indices of the two points (M, 3) that are farthest apart, exactly.

    Points are visited from the outermost inwards. Two at radii r and s from
    the middle are at most r + s apart, which excludes most pairs unseen.
    """
    radius = np.linalg.norm(points - (points.min(axis=0) + points.max(axis=0)) / 2, axis=1)
    order = np.argsort(-radius)
    points, radius = points[order], radius[order]
    best, pair = -1.0, (0, 0)
    block = 64
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
