"""Faults of the reference."""

from collections.abc import Sequence

import numpy as np

from aerodrake.model.reference.reference_curve import Motion
from aerodrake.scenario import AnyFault, ReferenceDrift, ReferenceJump, ReferenceNan


def with_faults(
    faults: Sequence[AnyFault], now: float, times: np.ndarray, motion: Motion
) -> Motion:
    """Returns a reference with faults applied, one after the other.

    A fault that is active now affects the whole horizon; a later one does not affect it yet.

    Args:
        faults: Any faults; only those of the reference are applied.
        now: s, reference time at which the reference is read.
        times: (T,) s, reference times of the rows.
        motion: (T, 3) m and (T, 3) m/s at these times.
    """
    p, v = motion[0].copy(), motion[1].copy()
    for fault in faults:
        if not fault.is_active(now):
            continue
        if isinstance(fault, ReferenceJump):
            p += fault.offset_m
        elif isinstance(fault, ReferenceDrift):
            p += np.outer(times - fault.start_s, fault.velocity_m_s)
            v += fault.velocity_m_s
        elif isinstance(fault, ReferenceNan):
            p[:] = v[:] = np.nan
    return p, v
