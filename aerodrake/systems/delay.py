"""Delay of a vector that is at first that of trim, as systems of Drake's own."""

import numpy as np
from pydrake.systems.primitives import AffineSystem, DiscreteTimeDelay

from aerodrake.support.arguments import Count, Period, Vector, checked


@checked
def make_delay(
    trim: Vector, steps: Count, period: Period
) -> tuple[AffineSystem, DiscreteTimeDelay, AffineSystem]:
    """Makes three systems, to be connected in series, that delay a vector by `steps` periods.

    They are the deviation from trim, its delay, and the sum with trim: the initial values of a
    delay are zeros.

    Args:
        trim: (m,) the vector before the delay has passed.
        steps: Delay in periods, 1 or more.
        period: s.
    """
    trim, identity = np.asarray(trim), np.eye(len(trim))
    # Its update stores the input before the update, which is one step of the delay.
    delay = DiscreteTimeDelay(period, steps - 1, len(trim))
    return AffineSystem(D=identity, y0=-trim), delay, AffineSystem(D=identity, y0=trim)
