"""Statistics of one last layer, by which it is used or gated off."""

import math
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

ERROR_FLOOR_M_S = 1e-4
"""Velocity errors below this value are negligible."""
MIN_IMPROVEMENT = 0.25
"""Mean improvement above which a layer is used: 1 for an exact Delta, 0 for one without effect."""


class GateCause(IntEnum):
    """Reason for which a layer is gated off; if several apply at one tick, the largest counts."""

    OK = 0  # The layer is used.
    UNPROVEN = 1
    UNHELPFUL = 2
    POISONED = 3
    DIVERGED = 4
    NOT_FINITE = 5


class LayerState(NamedTuple):
    """State of one layer's gate at a tick; means are running means over about `gate_s`.

    Attributes:
        cause: `OK` while the layer may be used.
        gated_s: s, time since it was gated off; 0 while it may be used.
        mean_benefit: m^2/s^2, mean of e_0^2 - e_1^2 (see `LearningGate`).
        mean_improvement: [-1, 1], mean of the improvement (see `LearningGate`).
    """

    cause: GateCause
    gated_s: float
    mean_benefit: float
    mean_improvement: float


@dataclass(frozen=True, eq=False)
class LayerGate:
    """Gate of one layer by its statistics, as in the table of `LearningGate`.

    Attributes:
        gate_s: s, averaging time; with 0 only non-finite layers are gated off.
        dt: s, period.
    """

    gate_s: float
    dt: float

    def start(self, is_used: bool) -> LayerState:
        """Returns the state before the first sample: OK or UNPROVEN."""
        if is_used:
            return LayerState(GateCause.OK, 0.0, 0.0, 0.0)
        return LayerState(GateCause.UNPROVEN, 0.0, 0.0, -1.0)

    def update(self, state: LayerState, nominal: float, corrected: float) -> LayerState:
        """Updates the means by e_0^2 and e_1^2 of a sample, m^2/s^2, if both are finite."""
        if not math.isfinite(nominal + corrected):
            return state
        ratio = improvement(nominal, corrected)
        return state._replace(
            mean_benefit=self.mean(state.mean_benefit, nominal - corrected),
            mean_improvement=self.mean(state.mean_improvement, ratio),
        )

    def is_harmful(self, state: LayerState) -> bool:
        """Returns True if the layer is not gated off and worsens the prediction."""
        is_harmful = state.mean_benefit < -(ERROR_FLOOR_M_S**2) or state.mean_improvement < 0
        return state.cause == GateCause.OK and is_harmful

    def is_proven(self, state: LayerState) -> bool:
        """Returns True if the layer improves the prediction enough to be used again."""
        return self.gate_s == 0 or state.mean_improvement > MIN_IMPROVEMENT

    def apply(self, state: LayerState, cause: GateCause, may_return: bool) -> LayerState:
        """Returns the state after the layer is gated off, for a `cause` of this tick, or on."""
        was_used = state.cause == GateCause.OK
        gated_s = 0.0 if was_used else state.gated_s + self.dt
        if cause != GateCause.OK:
            return state._replace(cause=cause, gated_s=gated_s, mean_improvement=-1.0)
        if was_used:
            return state
        if not may_return:
            return state._replace(gated_s=gated_s)
        # Errors from before the layer was gated off must not gate it off again.
        benefit = max(state.mean_benefit, 0.0)
        return state._replace(cause=GateCause.OK, gated_s=0.0, mean_benefit=benefit)

    def mean(self, mean: np.ndarray | float, newest: np.ndarray | float) -> Any:
        """Returns a running mean after the newest value; numbers, or arrays (3,)."""
        return mean + self.sample_weight * (newest - mean)

    @cached_property
    def sample_weight(self) -> float:
        """Weight of the newest sample in a running mean."""
        return -math.expm1(-self.dt / self.gate_s)


def improvement(before: float, after: float) -> float:
    """Returns the improvement from one squared error to another, in m^2/s^2, in [-1, 1]."""
    return (before - after) / (before + after + ERROR_FLOOR_M_S**2)
