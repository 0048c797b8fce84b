"""Envelope of references that the vehicle can follow, and the check of a reference."""

from enum import IntEnum
from typing import NamedTuple, Self

import numpy as np

from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

JUMP_M = 0.1
"""Deviation from the extrapolated last position above which a reference has jumped."""


class ReferenceVerdict(IntEnum):
    """Result of the check of a reference. A jump is followed, at the MPC's approach speed."""

    OK = 0
    NOT_FINITE = 1
    OUT_OF_REACH = 2
    TOO_FAST = 3
    JUMPED = 4


class Envelope(NamedTuple):
    """Limits of position and velocity within which a reference is followed.

    Attributes:
        start: (3,) m, initial position of the end-effector.
        lowest: m, smallest height.
        farthest: m, largest distance from the start.
        fastest: m/s, largest velocity along an axis.
    """

    start: np.ndarray
    lowest: float
    farthest: float
    fastest: float

    @classmethod
    def make(cls, config: Supervisor, start: np.ndarray) -> Self:
        """Returns a scenario's envelope for an end-effector that starts at `start` (3,) m."""
        return cls(np.array(start), config.lowest_m, config.farthest_m, config.fastest_m_s)


@compiled
def check_point(envelope: Envelope, point: np.ndarray) -> int:
    """Returns the `ReferenceVerdict` on a point (6,), p_Ed in m and p_Ed' in m/s, by itself."""
    if not np.all(np.isfinite(point)):
        return ReferenceVerdict.NOT_FINITE.value
    away = point[:3] - envelope.start
    if point[2] < envelope.lowest or np.sqrt(np.sum(away * away)) > envelope.farthest:
        return ReferenceVerdict.OUT_OF_REACH.value
    for i in range(3):
        if abs(point[3 + i]) > envelope.fastest:
            return ReferenceVerdict.TOO_FAST.value
    return ReferenceVerdict.OK.value


@compiled
def check_points(envelope: Envelope, points: np.ndarray) -> np.ndarray:
    """Returns the `ReferenceVerdict` (T,) on each of the points (T, 6), as `check_point`."""
    verdicts = np.empty(len(points), dtype=np.int64)
    for i in range(len(points)):
        verdicts[i] = check_point(envelope, points[i])
    return verdicts


class GuardState(NamedTuple):
    """State of the reference guard after a tick.

    Attributes:
        accepted: (6,) p_Ed in m and p_Ed' in m/s that was passed on at the tick.
        requested: (6,) that was requested then.
        verdict: The `ReferenceVerdict` on it.
    """

    accepted: np.ndarray
    requested: np.ndarray
    verdict: int


@compiled
def guard_reference(
    envelope: Envelope, requested: np.ndarray, state: GuardState, dt: float
) -> tuple[np.ndarray, int]:
    """Returns the reference to be followed now and over the horizon, and the verdict on now.

    From the first stage outside the envelope on, it rests at the last position inside.

    Args:
        envelope: Limits.
        requested: (N + 1, 6) p_Ed, p_Ed' in m and m/s, now and at each stage.
        state: State after the last tick.
        dt: s, between ticks.

    Returns:
        (N + 1, 6) as `requested`, and a `ReferenceVerdict`.
    """
    accepted, is_refused = requested.copy(), False
    verdict = check_point(envelope, requested[0])
    for k in range(len(requested)):
        is_refused = is_refused or check_point(envelope, requested[k]) != ReferenceVerdict.OK.value
        if is_refused:
            accepted[k] = state.accepted if k == 0 else accepted[k - 1]
            accepted[k, 3:] = 0.0
    if verdict == ReferenceVerdict.OK.value:
        now, last = requested[0], state.requested
        jump = now[:3] - last[:3] - dt / 2 * (now[3:] + last[3:])
        if np.sqrt(np.sum(jump * jump)) > JUMP_M:
            verdict = ReferenceVerdict.JUMPED.value
    return accepted, verdict
