"""Health of a sample, by group: verdicts of the sample check, and times without samples."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from aerodrake.support.compiled import compiled


class Verdict(IntEnum):
    """Verdict on a group of a sample: the first that applies of STALE, NOT_FINITE, FROZEN, JUMP."""

    # Accepted.
    OK = 0
    # NaN or infinite, a quaternion that is not of unit length, or beyond `MAX_MAGNITUDE`.
    NOT_FINITE = 1
    # Its time stamp has not advanced.
    STALE = 2
    # Bitwise equal to the previous one although it should have moved by `RESOLUTION`.
    FROZEN = 3
    # Consistent neither with the last accepted one nor with the prediction.
    JUMP = 4
    # A position that is accepted after a lasting jump, or after a start without positions.
    RESET = 5


class SampleHealth(NamedTuple):
    """Health of a sample, by group: the parts of the port `sample_health` (6).

    Attributes:
        ages: (3,) s since the last accepted sample, 0 if this one is accepted.
        verdicts: (3,) each a `Verdict`.
    """

    ages: np.ndarray
    verdicts: np.ndarray


@compiled
def split_health(vector: np.ndarray) -> SampleHealth:
    """Returns the parts of a vector (6,) of the port `sample_health`, as views."""
    return SampleHealth(vector[:3], vector[3:])


@compiled
def is_accepted(verdict: float) -> bool:
    """Returns True if a `Verdict` is that of an accepted group."""
    return verdict == Verdict.OK.value or verdict == Verdict.RESET.value
