"""Gate that passes the network's Delta only while Delta improves the prediction."""

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from aerodrake.scenario import Residual

ERROR_FLOOR_M_S = 1e-4
"""Velocity errors below this value are negligible."""
MAX_CORRECTION_M_S = 1.0
"""Largest plausible |c Delta|, the velocity that Delta adds in one period."""
MAX_SAMPLE_OFFSET_M_S = 0.5
"""Bound on one label's offset in the running mean; larger offsets are outliers."""
FADE_IN = 2.0
"""Duration in which Delta returns, in units of `gate_s`: a step would disturb the flight."""
FADE_OUT = 0.5
"""Duration in which the last valid Delta fades out, in units of `gate_s`."""
NOISE_DEVIATIONS = 5.0
"""Standard deviations of noise that a mean offset may have beyond its bound."""
REJECTION_RATIO = 0.25
"""Ratio of the mean offset to its bound above which labels are not learned."""
MIN_IMPROVEMENT = 0.25
"""Mean improvement above which Delta is used: 1 for an exact Delta, 0 for one without effect."""


class GateCause(IntEnum):
    """Reason for which Delta is gated off; if several apply at one tick, the largest counts."""

    OK = 0  # Delta is used.
    UNPROVEN = 1
    UNHELPFUL = 2
    POISONED = 3
    DIVERGED = 4
    NOT_FINITE = 5


class VelocitySample(NamedTuple):
    """One velocity prediction, compared with the measurement one period later.

    Attributes:
        target: (3,) m/s, label: measured velocity minus the model's prediction without Delta.
        correction: (3,) m/s, c Delta, the network's prediction of the label.
        offset: (3,) m/s, mean of the velocities measured at both ends, minus the
            measured displacement over the period: 0 if both measurements agree.
    """

    target: np.ndarray
    correction: np.ndarray
    offset: np.ndarray


class GateState(NamedTuple):
    """State of the gate at a tick; means are running means over about `gate_s`.

    Attributes:
        cause: `OK` while Delta is used.
        gated_s: s, time since Delta was gated off; 0 while it is used.
        blend: [0, 1], blend factor of Delta.
        fade_out: (3,) m/s, c Delta from which the output fades to zero.
        mean_offset: (3,) m/s, mean offset of the labels.
        mean_square_offset: m^2/s^2, mean squared length of the offset.
        mean_benefit: m^2/s^2, mean of e_0^2 - e_1^2 (see `LearningGate`).
        mean_improvement: [-1, 1], mean of the improvement (see `LearningGate`).
    """

    cause: GateCause
    gated_s: float
    blend: float
    fade_out: np.ndarray
    mean_offset: np.ndarray
    mean_square_offset: float
    mean_benefit: float
    mean_improvement: float


@dataclass(frozen=True, eq=False)
class LearningGate:
    """Gates Delta off while it would not improve the prediction, and rejects suspect labels.

    e_0 and e_1 are the errors of the predicted velocity without and with Delta, the
    mean offset of the labels removed. The improvement of a sample is

        (e_0^2 - e_1^2) / (e_0^2 + e_1^2 + floor^2),

    and its running mean r begins at -1 at the start and whenever Delta is gated off.

    | cause | entered when | left when | Delta meanwhile |
    |---|---|---|---|
    | UNPROVEN | at the start | r > 1/4 | 0 |
    | UNHELPFUL | mean of e_0^2 - e_1^2 below -floor^2, or r < 0 | r > 1/4 | 0 at once |
    | POISONED | mean offset > bound | r > 1/4 and mean offset < bound / 4 | fades out |
    | DIVERGED | theta outside `max_drift`, or c Delta > 1 m/s | r > 1/4 | fades out |
    | NOT_FINITE | theta or Delta NaN or infinite | r > 1/4 | fades out |

    r exceeds 1/4 after about `gate_s` at the earliest. Delta then returns by a linear ramp
    (`FADE_IN`), and fades out by another (`FADE_OUT`). The bound of the mean offset is
    `max_offset_m_s` plus a margin for noise; above a quarter of it, labels are not learned. Where
    e_0 is below the floor, r stays near 0 and Delta is not used. With `gate_s` = 0 only
    NOT_FINITE gates Delta off.

    Attributes:
        config: The gate uses `mode`, `gate_s`, `max_offset_m_s` and `max_drift`.
        theta_offline: (3, m) m/s, last layer of c Delta, centre of the ball of `max_drift`.
        dt: s, period.
    """

    config: Residual
    theta_offline: np.ndarray
    dt: float

    def start(self) -> GateState:
        """Returns the state before the first sample: UNPROVEN, or OK without a gate."""
        if self.config.guards.gate_s == 0 or self.config.mode == "off":
            return GateState(GateCause.OK, 0.0, 1.0, np.zeros(3), np.zeros(3), 0.0, 0.0, 0.0)
        return GateState(GateCause.UNPROVEN, 0.0, 0.0, np.zeros(3), np.zeros(3), 0.0, 0.0, -1.0)

    def update(self, state: GateState, sample: VelocitySample) -> GateState:
        """Updates the running means by one sample; NaN and infinite samples are ignored."""
        size = math.hypot(*sample.offset)
        if self.config.guards.gate_s == 0 or not math.isfinite(size):
            return state
        bounded = sample.offset * (MAX_SAMPLE_OFFSET_M_S / max(size, MAX_SAMPLE_OFFSET_M_S))
        offset = self._mean(state.mean_offset, bounded)
        square = self._mean(state.mean_square_offset, float(bounded @ bounded))
        state = state._replace(mean_offset=offset, mean_square_offset=square)
        target = sample.target - offset
        with np.errstate(over="ignore", invalid="ignore"):
            error = sample.correction - target
            e0_square, e1_square = float(target @ target), float(error @ error)
        total, benefit = e0_square + e1_square, e0_square - e1_square
        if size > MAX_SAMPLE_OFFSET_M_S or not math.isfinite(total):
            return state
        improvement = self._mean(state.mean_improvement, benefit / (total + ERROR_FLOOR_M_S**2))
        benefit = self._mean(state.mean_benefit, benefit)
        return state._replace(mean_benefit=benefit, mean_improvement=improvement)

    def check_statistics(self, state: GateState) -> GateCause:
        """Returns POISONED, UNHELPFUL or OK, from the running means."""
        if self._offset_ratio(state) > 1:
            return GateCause.POISONED
        is_harmful = state.mean_benefit < -(ERROR_FLOOR_M_S**2) or state.mean_improvement < 0
        return GateCause.UNHELPFUL if state.cause == GateCause.OK and is_harmful else GateCause.OK

    def rejects_labels(self, state: GateState) -> bool:
        """Returns True if the labels' mean offset is too large to learn from them."""
        return self._offset_ratio(state) > REJECTION_RATIO

    def check_layer(self, theta: np.ndarray, correction: np.ndarray) -> GateCause:
        """Returns NOT_FINITE, DIVERGED or OK, from theta (3, m) m/s and its correction (3,) m/s."""
        if not (np.isfinite(theta).all() and np.isfinite(correction).all()):
            return GateCause.NOT_FINITE
        if self.config.guards.gate_s == 0:
            return GateCause.OK
        drift, bound = np.linalg.norm(theta - self.theta_offline), self.config.guards.max_drift
        if bound > 0 and drift > bound * (1 + 1e-6):
            return GateCause.DIVERGED
        return GateCause.DIVERGED if math.hypot(*correction) > MAX_CORRECTION_M_S else GateCause.OK

    def apply(self, state: GateState, cause: GateCause, last: np.ndarray) -> GateState:
        """Returns the state after Delta is gated off, for the largest `cause` of this tick, or on.

        The output fades out from `last`, (3,) m/s, c Delta as used at the tick before.
        """
        was_used = state.cause == GateCause.OK
        gated_s = 0.0 if was_used else state.gated_s + self.dt
        if cause != GateCause.OK:
            fade_out = last if was_used else state.fade_out
            if was_used and cause == GateCause.UNHELPFUL:
                fade_out = np.zeros(3)
            return state._replace(
                cause=cause, gated_s=gated_s, blend=0.0, fade_out=fade_out, mean_improvement=-1.0
            )
        if not self._is_proven(state):
            return state._replace(gated_s=gated_s)
        ramp_s = FADE_IN * self.config.guards.gate_s
        blend = min(1.0, state.blend + self.dt / ramp_s) if ramp_s > 0 else 1.0
        # Errors from before Delta was gated off must not gate it off again.
        benefit = state.mean_benefit if was_used else max(state.mean_benefit, 0.0)
        return state._replace(cause=GateCause.OK, gated_s=0.0, blend=blend, mean_benefit=benefit)

    def output(self, state: GateState, correction: np.ndarray) -> np.ndarray:
        """Returns the c Delta to use, (3,) m/s, from the network's `correction`, (3,) m/s."""
        if state.cause == GateCause.OK:
            return state.blend * correction
        fade_s = FADE_OUT * self.config.guards.gate_s
        if state.gated_s >= fade_s:
            return np.zeros(3)
        return state.fade_out * (1 - state.gated_s / fade_s)

    def _is_proven(self, state: GateState) -> bool:
        if state.cause == GateCause.OK or self.config.guards.gate_s == 0:
            return True
        is_over = state.cause != GateCause.POISONED or not self.rejects_labels(state)
        return is_over and state.mean_improvement > MIN_IMPROVEMENT

    def _offset_ratio(self, state: GateState) -> float:
        """Returns the ratio of the labels' mean offset to its bound; 0 without a bound."""
        bound = self.config.guards.max_offset_m_s
        if bound == 0 or self.config.guards.gate_s == 0:
            return 0.0
        # Standard deviation of the mean: position noise is uncorrelated between samples.
        noise = self._sample_weight * math.sqrt(state.mean_square_offset)
        return math.hypot(*state.mean_offset) / (bound + NOISE_DEVIATIONS * noise)

    def _mean(self, mean: np.ndarray | float, newest: np.ndarray | float) -> Any:
        """Returns a running mean after the newest value."""
        return mean + self._sample_weight * (newest - mean)

    @cached_property
    def _sample_weight(self) -> float:
        """Weight of the newest sample in a running mean."""
        return -math.expm1(-self.dt / self.config.guards.gate_s)
