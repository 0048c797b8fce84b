"""Blend of the last layers' Delta, without steps when another layer is used."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Generic, NamedTuple, TypeVar

import numpy as np

FADE_IN = 2.0
"""Duration in which a layer's Delta fades in, in units of `gate_s`: a step disturbs the flight."""
FADE_OUT = 0.5
"""Duration in which the last valid Delta fades out, in units of `gate_s`."""
FADE_OUT_UNHELPFUL = 0.1
"""Duration in which a Delta that worsens the prediction fades out, in units of `gate_s`."""
ROUNDING = 1e-9
"""Weights below this value are rounding errors of zero."""

Value = TypeVar("Value")


class PerLayer(NamedTuple, Generic[Value]):
    """One value for each last layer: as trained offline, and as learned online."""

    offline: Value
    learned: Value


class DeltaSource(IntEnum):
    """Layer whose Delta is used, from the best to the last choice."""

    LEARNED = 0
    OFFLINE = 1
    NONE = 2  # Delta is zero, or fades to it.

    @property
    def label(self) -> str:
        """Name in summaries."""
        return self.name.lower()


class BlendState(NamedTuple):
    """State of the blend at a tick.

    Attributes:
        source: Layer whose Delta is used.
        weights: [0, 1] of each layer's Delta; their sum is at most 1.
        fade: [0, 1], weight of `excess`.
        fade_step: Decrease of `fade` in one tick.
        excess: (3,) m/s, c Delta before the last change to a worse source, minus that after it.
    """

    source: DeltaSource
    weights: PerLayer[float]
    fade: float
    fade_step: float
    excess: np.ndarray


@dataclass(frozen=True, eq=False)
class DeltaBlend:
    """Blends the layers' c Delta, so that a change of the source causes no step.

    The weight of the source's Delta increases to 1 in `FADE_IN`; that of the other one decreases
    with it. At a change to a worse source the layer that was used may be invalid. Its last
    output therefore fades out, and the worse source has the former sum of weights at once. If the
    output was harmful, its excess over the new source's Delta is first shortened to the length
    of the latter; without a new source it is dropped.

    Attributes:
        gate_s: s, unit of durations; with 0 changes take one tick.
        dt: s, period.
    """

    gate_s: float
    dt: float

    def start(self, source: DeltaSource) -> BlendState:
        """Returns the state before the first tick: `source` has its full weight."""
        weights = PerLayer(
            float(source == DeltaSource.OFFLINE), float(source == DeltaSource.LEARNED)
        )
        return BlendState(source, weights, 0.0, 0.0, np.zeros(3))

    def step(
        self,
        state: BlendState,
        source: DeltaSource,
        is_harmful: bool,
        corrections: PerLayer[np.ndarray],
        last: np.ndarray,
    ) -> tuple[np.ndarray, BlendState]:
        """Returns the c Delta to use, (3,) m/s, and the state after the tick.

        Args:
            state: Before the tick.
            source: Layer to use.
            is_harmful: True if the source before worsened the prediction.
            corrections: (3,) m/s, c Delta of each layer.
            last: (3,) m/s, c Delta used at the tick before.
        """
        is_worse = source > state.source
        weights = self._weights(state.weights, source)
        blended = np.zeros(3)
        for weight, correction in zip(weights, corrections, strict=True):
            if weight > 0:  # Otherwise it may be NaN.
                blended += weight * correction
        state = state._replace(source=source, weights=weights, fade=self._faded(state))
        if is_worse and self.gate_s > 0:
            excess, fade_s = last - blended, FADE_OUT * self.gate_s
            if is_harmful:
                fade_s = FADE_OUT_UNHELPFUL * self.gate_s
                size = math.hypot(*excess)
                excess *= min(1.0, math.hypot(*blended) / size) if size > 0 else 0.0
            state = state._replace(fade=1.0, fade_step=self.dt / fade_s, excess=excess)
        return blended + state.fade * state.excess, state

    def _weights(self, weights: PerLayer[float], source: DeltaSource) -> PerLayer[float]:
        offline, learned = weights
        ramp = self.dt / (FADE_IN * self.gate_s) if self.gate_s > 0 else 1.0
        match source:
            case DeltaSource.LEARNED:
                learned = min(1.0, learned + ramp)
                return PerLayer(min(offline, 1.0 - learned), learned)
            case DeltaSource.OFFLINE:
                return PerLayer(min(1.0, offline + learned + ramp), 0.0)
            case DeltaSource.NONE:
                return PerLayer(0.0, 0.0)

    def _faded(self, state: BlendState) -> float:
        fade = state.fade - state.fade_step
        return fade if fade > ROUNDING else 0.0
