"""Whether what the residual network says may be used: a judge that learns nothing itself."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np

from aerodrake.scenario import Residual

FLOOR_M_S = 1e-4
"""Errors of a predicted velocity below this are none: they neither help nor harm."""

MOST_DELTA_M_S = 1.0
"""No residual is as large as this."""

OUTLIER_M_S = 0.5
"""Samples whose label is off the measured motion by more count no more than this."""

RAMP = 2.0
"""Over how many `judge_s` Delta comes back: at once, it may shake what it predicts."""

FADE = 0.5
"""Over how many `judge_s` the last sound Delta goes: at once, it shakes the flight as well."""

NOISE = 5.0
"""By how many deviations of noise a mean offset is explained."""

DOUBTFUL = 0.25
"""From which share of the offset that is too much nothing is learned, nor forgiven."""

HELPFUL = 0.25
"""Mean gain from which Delta is used; 1 for one that is always right, 0 without effect."""


HEALTH_SIZE = 12
"""Numbers of `Health` as a vector."""


NONE = np.zeros(3)
"""(3,) m/s, Delta where nothing is used."""


class Cause(IntEnum):
    """Why Delta is held at zero; of two at one tick it is the later."""

    OK = 0  # It is not.
    UNPROVEN = 1  # It has yet to help.
    UNHELPFUL = 2  # It has made predictions worse.
    POISONED = 3  # Labels contradict the measured motion.
    DIVERGED = 4  # The last layer left the ball of `max_drift`, or Delta is out of proportion.
    NOT_FINITE = 5  # One of its numbers is no number.


class Evidence(NamedTuple):
    """What one sample says of Delta.

    Attributes:
        target: (3,) m/s, measured velocity minus the model's prediction without Delta.
        correction: (3,) m/s, c * Delta, which was to predict it.
        offset: (3,) m/s, mean of the velocities measured at its two ends, minus the
            measured displacement in between by the time it took.
    """

    target: np.ndarray
    correction: np.ndarray
    offset: np.ndarray


@dataclass(frozen=True, eq=False)
class Health:
    """What is known of the learner at a tick.

    Attributes:
        cause: Why Delta is zero, or `OK`.
        held_s: s, for how long.
        parting: (3,) m/s, Delta from which it goes to zero meanwhile.
        share: [0, 1], of Delta that is used.
        offset: (3,) m/s, running mean of the labels' offset.
        offset_square: m^2/s^2, and of its square.
        benefit: m^2/s^2, running mean of the square error without Delta minus that with it.
        gain: [-1, 1], running mean of the same, relative to their sum.
    """

    cause: Cause
    held_s: float
    share: float
    parting: np.ndarray
    offset: np.ndarray
    offset_square: float
    benefit: float
    gain: float

    @classmethod
    def from_vector(cls, x: np.ndarray) -> Health:
        """Of x (`HEALTH_SIZE`,), the reverse of `to_vector`."""
        return cls(Cause(int(x[0])), x[1], x[2], x[3:6].copy(), x[6:9].copy(), *x[9:])

    def to_vector(self) -> np.ndarray:
        """(`HEALTH_SIZE`,): its attributes in their order."""
        return np.array(
            [
                *(self.cause, self.held_s, self.share, *self.parting, *self.offset),
                *(self.offset_square, self.benefit, self.gain),
            ]
        )


@dataclass(frozen=True, eq=False)
class LearnerJudge:
    """Rules by which Delta is used, or held at zero until it would have helped.

    Means run over about `judge_s`. Delta is given up

    - where the last layer is not finite, left the ball of `max_drift`, or says more
      than `MOST_DELTA_M_S`;
    - where labels are off the measured motion by more than `max_offset_m_s` in the
      mean, and by more than noise explains: velocity has to be what position does
      (`Evidence.offset`);
    - where the mean square error of predictions is larger with Delta than without.
      One large error is enough.

    What was used before goes to zero over `FADE`, except where it was what did harm.

    It is used again, and for the first time, when the mean gain

        (e_0^2 - e_1^2) / (e_0^2 + e_1^2 + floor^2),   e_1 with Delta, e_0 without,

    which begins at -1, is above `HELPFUL`: after `judge_s` at the earliest, however large
    errors were before; and, after a poisoning, when the offset is no longer in doubt.
    What is in doubt is not learned, lest much has been when it is found to be poison.
    Errors are taken against labels without their mean offset, so that nobody is judged
    by what poisoned them. Where even without Delta errors are below the floor, there is
    nothing to help with, and Delta stays zero.

    Attributes:
        config: Of the rules, `judge_s`, `max_offset_m_s` and `max_drift`.
        theta_offline: (3, m) m/s, centre of the ball.
        dt: s, period.
    """

    config: Residual
    theta_offline: np.ndarray
    dt: float

    def start(self) -> Health:
        """Before the first sample: Delta has yet to show that it helps, if anybody asks."""
        if self.config.judge_s == 0:
            return Health(Cause.OK, 0.0, 1.0, np.zeros(3), np.zeros(3), 0.0, 0.0, 0.0)
        return Health(Cause.UNPROVEN, 0.0, 0.0, np.zeros(3), np.zeros(3), 0.0, 0.0, -1.0)

    def weigh(self, health: Health, evidence: Evidence) -> Health:
        """The means after one more sample; one with what is not finite says nothing."""
        off = math.hypot(*evidence.offset)
        if self.config.judge_s == 0 or not math.isfinite(off):
            return health
        new = self._newest
        is_outlier = off > OUTLIER_M_S
        bounded = evidence.offset * (OUTLIER_M_S / off) if is_outlier else evidence.offset
        offset = health.offset + new * (bounded - health.offset)
        square = health.offset_square + new * (float(bounded @ bounded) - health.offset_square)
        health = replace(health, offset=offset, offset_square=square)
        if is_outlier:
            return health
        target = evidence.target - offset
        with np.errstate(over="ignore", invalid="ignore"):
            error = evidence.correction - target
            without, having = float(target @ target), float(error @ error)
        if not math.isfinite(without + having):
            return health
        relative = (without - having) / (without + having + FLOOR_M_S**2)
        return replace(
            health,
            benefit=health.benefit + new * (without - having - health.benefit),
            gain=health.gain + new * (relative - health.gain),
        )

    def verdict(self, health: Health) -> Cause:
        """What the means say against the learner; `OK` if nothing."""
        if self._too_far_off(health) > 1:
            return Cause.POISONED
        is_harmful = health.benefit < -(FLOOR_M_S**2) or health.gain < 0
        return Cause.UNHELPFUL if health.cause == Cause.OK and is_harmful else Cause.OK

    def doubts(self, health: Health) -> bool:
        """Whether labels are off by so much that they had better not be learned."""
        return self._too_far_off(health) > DOUBTFUL

    def inspect(self, theta: np.ndarray, delta: np.ndarray) -> Cause:
        """What is wrong with a last layer and the Delta it gives; `OK` if nothing.

        Without `judge_s` all that is finite will do.

        Args:
            theta: (3, m) m/s, the last layer.
            delta: (3,) m/s, Delta.
        """
        if not (np.isfinite(theta).all() and np.isfinite(delta).all()):
            return Cause.NOT_FINITE
        if self.config.judge_s == 0:
            return Cause.OK
        drift, most = np.linalg.norm(theta - self.theta_offline), self.config.max_drift
        is_astray = most > 0 and drift > most * (1 + 1e-6)
        return Cause.DIVERGED if is_astray or math.hypot(*delta) > MOST_DELTA_M_S else Cause.OK

    def rule(self, health: Health, found: Cause, last: np.ndarray) -> Health:
        """How much of Delta is used now, after what was found at this tick.

        Args:
            health: With what the newest sample said.
            found: What is wrong.
            last: (3,) m/s, Delta as it was used at the tick before. It was sound, unless
                it was what did the harm.
        """
        held_s = 0.0 if health.cause == Cause.OK else health.held_s + self.dt
        if found != Cause.OK:
            parting = health.parting
            if health.cause == Cause.OK:
                parting = np.zeros(3) if found == Cause.UNHELPFUL else last
            health = replace(health, cause=found, held_s=held_s, share=0.0, gain=-1.0)
            return replace(health, parting=parting)
        if not self._is_proven(health):
            return replace(health, held_s=held_s)
        ramp_s = RAMP * self.config.judge_s
        share = min(1.0, health.share + self.dt / ramp_s) if ramp_s > 0 else 1.0
        # What harm was done before has had its answer.
        benefit = health.benefit if health.cause == Cause.OK else max(health.benefit, 0.0)
        return replace(health, cause=Cause.OK, held_s=0.0, share=share, benefit=benefit)

    def used(self, health: Health, delta: np.ndarray) -> np.ndarray:
        """(3,) m/s, what is used where the network says `delta` (3,) m/s."""
        if health.cause == Cause.OK:
            return health.share * delta
        fade_s = FADE * self.config.judge_s
        return health.parting * (1 - health.held_s / fade_s) if health.held_s < fade_s else NONE

    def _is_proven(self, health: Health) -> bool:
        if health.cause == Cause.OK or self.config.judge_s == 0:
            return True
        is_over = health.cause != Cause.POISONED or not self.doubts(health)
        return is_over and health.gain > HELPFUL

    def _too_far_off(self, health: Health) -> float:
        """The labels' mean offset by the one that is too much; 0 where nothing is."""
        most = self.config.max_offset_m_s
        if most == 0 or self.config.judge_s == 0:
            return 0.0
        # The part of noise in the mean: that of position comes and goes between samples.
        noise = self._newest * math.sqrt(health.offset_square)
        return math.hypot(*health.offset) / (most + NOISE * noise)

    @cached_property
    def _newest(self) -> float:
        """The share of the newest sample in a running mean."""
        return -math.expm1(-self.dt / self.config.judge_s)
