"""Modes of the sampled closed loop: growth, frequency, damping and participants."""

from dataclasses import dataclass
from typing import NamedTuple


class Participant(NamedTuple):
    """Share of a body motion or a system in a mode.

    Attributes:
        name: A motion of the plant (`roll`, `pitch`, `yaw`, `x`, `y`, `z` or a joint's name), or
            the name of another system.
        share: Sum of the participation factors |left_i right_i| of its states, of all 1.
    """

    name: str
    share: float


@dataclass(frozen=True)
class Eigenmode:
    """One real eigenvalue, or one pair of complex conjugates, of the sampled closed loop.

    Attributes:
        eigenvalue: z, per period; of a pair the one with positive imaginary part.
        growth_1_s: 1/s, ln|z| / dt; negative for a decaying mode.
        frequency_hz: Of the oscillation, phase of z over 2 pi dt. Its alias is resolved by the
            motion of the plant within the period.
        damping: Damping ratio, -growth over the magnitude of ln(z) / dt; 1 for a decay without
            oscillation, negative for an unstable mode.
        participants: The largest share first; shares below 1 % are omitted.
        is_stable: False if the mode grows, faster than by the errors of the linearisation; along a
            path also faster than the loop itself changes.
    """

    eigenvalue: complex
    growth_1_s: float
    frequency_hz: float
    damping: float
    participants: tuple[Participant, ...]
    is_stable: bool
