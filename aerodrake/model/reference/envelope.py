"""References that come from anywhere: followed where they can be, held where not."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from aerodrake.scenario import Supervisor
from aerodrake.support.compiled import compiled

JUMP_M = 0.1
"""What a reference is elsewhere than its velocity took it, if it has jumped."""


class ReferenceVerdict(IntEnum):
    """What is the matter with a reference. A jump is followed, at the MPC's approach speed."""

    OK = 0
    NOT_FINITE = 1
    OUT_OF_REACH = 2
    TOO_FAST = 3
    JUMPED = 4


class Envelope(NamedTuple):
    """Where a reference may be, and how fast.

    Attributes:
        start: (3,) m, where the end-effector starts.
        lowest: m, smallest height.
        farthest: m, largest distance from the start.
        fastest: m/s, largest velocity along an axis.
    """

    start: np.ndarray
    lowest: float
    farthest: float
    fastest: float

    @classmethod
    def make(cls, config: Supervisor, start: np.ndarray) -> Envelope:
        """Of the scenario, for an end-effector that starts at `start` (3,) m."""
        return cls(np.array(start), config.lowest_m, config.farthest_m, config.fastest_m_s)


@compiled
def judged(envelope: Envelope, row: np.ndarray) -> int:
    """What is the matter with a row (6,), p_Ed m and p_Ed' m/s, alone: a `ReferenceVerdict`."""
    if not np.all(np.isfinite(row)):
        return 1
    away = row[:3] - envelope.start
    if row[2] < envelope.lowest or np.sqrt(np.sum(away * away)) > envelope.farthest:
        return 2
    for i in range(3):
        if abs(row[3 + i]) > envelope.fastest:
            return 3
    return 0


@compiled
def accepted(
    envelope: Envelope, rows: np.ndarray, last: np.ndarray, asked: np.ndarray, dt: float
) -> tuple[np.ndarray, int]:
    """A reference, now and over the horizon, as it is to be followed.

    It holds still from where it cannot be followed, at the last place at which it can.

    Args:
        envelope: Where it may be.
        rows: (N + 1, 6) p_Ed, p_Ed' in m and m/s, now and at each stage.
        last: (6,) what was accepted a tick ago,
        asked: (6,) and what was asked for then.
        dt: s, a tick.

    Returns:
        (N + 1, 6), and the verdict on now.
    """
    found, held = rows.copy(), -1
    verdict = judged(envelope, rows[0])
    for k in range(len(rows)):
        if held < 0 and judged(envelope, rows[k]) != 0:
            held = k
        if held >= 0:
            found[k] = last if k == 0 else found[k - 1]
            found[k, 3:] = 0.0
    if verdict == 0:
        jump = rows[0, :3] - asked[:3] - dt / 2 * (rows[0, 3:] + asked[3:])
        if np.sqrt(np.sum(jump * jump)) > JUMP_M:
            verdict = 4
    return found, verdict
