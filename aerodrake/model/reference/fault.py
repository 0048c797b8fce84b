"""References that are not what they should be, for a time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from aerodrake.model.reference.curves import Motion
from aerodrake.scenario import AnyFault, ReferenceDrift, ReferenceJump, ReferenceNan


def faulty(
    faults: Sequence[AnyFault], now: float | np.ndarray, times: np.ndarray, motion: Motion
) -> Motion:
    """A reference with what is the matter with it, one fault after the other.

    Nobody knows of a fault before it is there: then it concerns all that is seen ahead.

    Args:
        faults: Of which those of the reference count.
        now: s, reference time at which it is looked at; for all rows, or (T,) for each.
        times: (T,) s, reference times of the rows.
        motion: (T, 3) m and (T, 3) m/s then.
    """
    p, v = motion[0].copy(), motion[1].copy()
    for fault in faults:
        active = np.broadcast_to(fault.is_active(now), times.shape)
        if isinstance(fault, ReferenceJump):
            p[active] += fault.offset_m
        elif isinstance(fault, ReferenceDrift):
            p[active] += np.outer(times[active] - fault.start_s, fault.velocity_m_s)
            v[active] += fault.velocity_m_s
        elif isinstance(fault, ReferenceNan):
            p[active] = v[active] = np.nan
    return p, v
