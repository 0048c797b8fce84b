"""Smooth paths near rounded waypoints."""

import numpy as np
from pydrake.trajectories import PiecewisePolynomial
from scipy.interpolate import make_lsq_spline, splev, splrep

DEGREE = 5
"""Degree of the smoothing splines, of which four derivatives are continuous."""

MIRRORED = 500
"""Largest number of points beyond each end, mirrored about it, to which a spline is fitted."""

END_WEIGHT = 1e5
"""Weight of the end points; that of the others is 1."""

ROWS_PER_KNOT = 4
"""Least number of rows between knots, so that fitting takes seconds at most."""

FEW = 500
"""Number of rows from which `ROWS_PER_KNOT` applies."""


def smooth_waypoints(times: np.ndarray, points: np.ndarray, step: float) -> PiecewisePolynomial:
    """Returns a smooth path near waypoints that were rounded, at rest at both ends.

    Each coordinate is a smoothing spline (Dierckx 1993, FITPACK) with few knots, whose mean squared
    distance from the points is that of rounding, step^2 / 12. Motion is mirrored about both ends;
    the first and the last point are kept. Outside `times` the path stays there. Noise with a
    standard deviation sigma is as rounding to sqrt(12) sigma.

    Args:
        times: (M,) s, ascending, M >= 2.
        points: (M, 3) m.
        step: m, above 0, to whose multiples the coordinates are rounded.

    Raises:
        ValueError: if many points are not near any smooth path.
    """
    _check_step(times, points, step)
    count = min(MIRRORED, 5 * len(times))
    mirrored_times = np.pad(times, count, "reflect", reflect_type="odd")
    weights = np.full(len(mirrored_times), np.sqrt(12) / step)
    weights[[count, -count - 1]] *= END_WEIGHT
    values, rates = np.empty_like(points), np.empty_like(points)
    for axis in range(3):
        mirrored = np.pad(points[:, axis], count, "reflect")
        # Without its full output it warns that few points cannot be smoothed.
        spline, *_ = splrep(
            mirrored_times, mirrored, weights, k=DEGREE, s=len(weights), full_output=True
        )
        values[:, axis], rates[:, axis] = splev(times, spline), splev(times, spline, der=1)
    values[[0, -1]], rates[[0, -1]] = points[[0, -1]], 0.0
    return PiecewisePolynomial.CubicHermite(times, values.T, rates.T)


def _check_step(times: np.ndarray, points: np.ndarray, step: float) -> None:
    """Raises ValueError if splines with a knot at each `ROWS_PER_KNOT` rows are not near enough."""
    if len(times) < FEW:
        return
    inner = times[ROWS_PER_KNOT:-ROWS_PER_KNOT:ROWS_PER_KNOT]
    knots = np.concatenate([np.repeat(times[0], 6), inner, np.repeat(times[-1], 6)])
    spline = make_lsq_spline(times, points, knots, DEGREE)
    squares = np.mean((spline(times) - points) ** 2, axis=0)
    if (squares > step**2 / 12).any():
        free = 1 - 1 / ROWS_PER_KNOT  # The splines follow this share of the rounding less.
        actual = np.sqrt(12 * squares.max() / free)
        raise ValueError(
            f"expected coordinates that are rounded to {step:g} m (reference.rounding_m), and "
            f"smooth otherwise; they deviate from a smooth path as if rounded to {actual:.2g} m"
        )
