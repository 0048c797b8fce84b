"""Detection of a lasting jump of the measured position."""

from typing import NamedTuple, Self

import numpy as np

from aerodrake.model.vehicle.rotation import length
from aerodrake.scenario import Filter
from aerodrake.support.compiled import compiled


class JumpLimits(NamedTuple):
    """Limits of a jump after which the filter starts again from the measured position.

    Attributes:
        reset_m: m, largest jump.
        reset_after_s: s, for which it has to last.
    """

    reset_m: float
    reset_after_s: float

    @classmethod
    def make(cls, config: Filter) -> Self:
        """Returns the limits of a scenario."""
        return cls(config.reset_m, config.reset_after_s)


class Jump(NamedTuple):
    """Common deviation of rejected positions from the prediction.

    Attributes:
        deviation: (3,) m, of the first of them.
        duration_s: s, time of samples that have had it; 0 without a jump.
    """

    deviation: np.ndarray
    duration_s: float

    @classmethod
    def none(cls) -> Self:
        """Returns the state without a jump."""
        return cls(np.zeros(3), 0.0)


@compiled
def extend_jump(jump: Jump, deviation: np.ndarray, tolerance: float, dt: float) -> Jump:
    """Returns the jump after one more rejected sample.

    Args:
        jump: Until the sample before.
        deviation: (3,) m, of the sample from the prediction.
        tolerance: m, difference up to which deviations are the same; otherwise the jump begins
            with this sample.
        dt: s, between samples.
    """
    if jump.duration_s > 0 and length(deviation - jump.deviation) <= tolerance:
        return Jump(jump.deviation, jump.duration_s + dt)
    return Jump(deviation, dt)


@compiled
def is_lasting(limits: JumpLimits, jump: Jump, tolerance: float, dt: float) -> bool:
    """Returns True if a jump lasts long enough, and is small enough, to start again from it.

    Args:
        limits: Size and duration.
        jump: Up to the present sample.
        tolerance: m, error of the prediction, by which the deviation may exceed the limit.
        dt: s, between samples; half of it is tolerated.
    """
    lasts = jump.duration_s >= limits.reset_after_s - dt / 2
    return lasts and length(jump.deviation) <= limits.reset_m + tolerance


@compiled
def has_jumped(jump: Jump, deviation: np.ndarray) -> bool:
    """Returns True if an accepted deviation (3,) m is nearer to the jump than to the prediction."""
    return jump.duration_s > 0 and length(deviation - jump.deviation) < length(deviation)
