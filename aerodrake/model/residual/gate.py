"""Gate that chooses which last layer estimates Delta: the learned one, the offline one or none."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from aerodrake.model.residual.delta_blend import BlendState, DeltaBlend, DeltaSource, PerLayer
from aerodrake.model.residual.layer_gate import GateCause, LayerGate, LayerState, improvement
from aerodrake.scenario import Residual

MAX_CORRECTION_M_S = 1.0
"""Largest plausible |c Delta|, the velocity that Delta adds in one period."""
MAX_SAMPLE_OFFSET_M_S = 0.5
"""Bound on one label's offset in the running mean; larger offsets are outliers."""
NOISE_DEVIATIONS = 5.0
"""Standard deviations of noise that a mean offset may have beyond its bound."""
REJECTION_RATIO = 0.25
"""Ratio of the mean offset to its bound above which labels are not learned."""
MAX_DISADVANTAGE = 0.25
"""Mean disadvantage of the learned layer to the offline one above which it is not used."""


class VelocitySample(NamedTuple):
    """One velocity prediction, compared with the measurement one period later.

    Attributes:
        target: (3,) m/s, label: measured velocity minus the model's prediction without Delta.
        corrections: (3,) m/s each, c Delta, the layers' predictions of the label.
        offset: (3,) m/s, mean of the velocities measured at both ends, minus the
            measured displacement over the period: 0 if both measurements agree.
    """

    target: np.ndarray
    corrections: PerLayer[np.ndarray]
    offset: np.ndarray


class GateState(NamedTuple):
    """State of the gate at a tick; means are running means over about `gate_s`.

    Attributes:
        layers: State of each layer's gate.
        blend: State of the blend of their Delta.
        mean_offset: (3,) m/s, mean offset of the labels.
        mean_square_offset: m^2/s^2, mean squared length of the offset.
        mean_advantage: [-1, 1], mean improvement from the offline to the learned layer.
    """

    layers: PerLayer[LayerState]
    blend: BlendState
    mean_offset: np.ndarray
    mean_square_offset: float
    mean_advantage: float


@dataclass(frozen=True, eq=False)
class LearningGate:
    """Uses the learned layer while it is proven, else the offline layer while that is, else none.

    Both layers are evaluated by the same samples. e_0 and e_1 are the errors of the predicted
    velocity without and with a layer's Delta, the mean offset of the labels removed. The
    improvement of a sample is

        (e_0^2 - e_1^2) / (e_0^2 + e_1^2 + floor^2),

    and its running mean r begins at -1 at the start and whenever the layer is gated off. The
    advantage a is the mean improvement from the offline to the learned layer; it begins at 0.

    | cause | of layer | entered when | left when | its Delta fades out in |
    |---|---|---|---|---|
    | UNPROVEN | both | at the start | r > 1/4 | |
    | UNHELPFUL | both | mean of e_0^2 - e_1^2 below -floor^2, or r < 0 | r > 1/4 | `gate_s` / 10 |
    | UNHELPFUL | learned | a < -1/4 while the offline layer is proven | r > 1/4 | `gate_s` / 10 |
    | POISONED | learned | mean offset > bound | r > 1/4, mean offset < bound / 4 | `gate_s` / 2 |
    | DIVERGED | both | theta outside `max_drift`, or c Delta > 1 m/s | r > 1/4 | `gate_s` / 2 |
    | NOT_FINITE | both | theta or Delta NaN or infinite | r > 1/4 | `gate_s` / 2 |

    Meanwhile Delta is that of the offline layer if its cause is OK, and zero otherwise. r exceeds
    1/4 after about `gate_s` at the earliest; while the offline layer is proven, the learned
    layer returns only with a >= 0. `DeltaBlend` makes these changes without steps, except that
    it drops the larger part of a large unhelpful Delta at once, and all of it without a layer.

    The bound of the mean offset is `max_offset_m_s` plus a margin for noise; above a quarter of
    it, labels are not learned. Where e_0 is below the floor, r stays near 0 and Delta is not
    used. With `gate_s` = 0 only NOT_FINITE gates a layer off.

    Attributes:
        config: The gate uses `mode`, `gate_s`, `max_offset_m_s` and `max_drift`.
        theta_offline: (3, m) m/s, last layer of c Delta, centre of the ball of `max_drift`.
        dt: s, period.
    """

    config: Residual
    theta_offline: np.ndarray
    dt: float

    @cached_property
    def _layer(self) -> LayerGate:
        return LayerGate(self.config.guards.gate_s, self.dt)

    @cached_property
    def _blend(self) -> DeltaBlend:
        return DeltaBlend(self.config.guards.gate_s, self.dt)

    def start(self) -> GateState:
        """Returns the state before the first sample: UNPROVEN, or OK without a gate."""
        layer = self._layer.start(self.config.guards.gate_s == 0 or self.config.mode == "off")
        layers = PerLayer(layer, layer)
        blend = self._blend.start(self._source(layers))
        return GateState(layers, blend, np.zeros(3), 0.0, 0.0)

    def update(self, state: GateState, sample: VelocitySample) -> GateState:
        """Updates the running means by one sample; NaN and infinite samples are ignored."""
        size, mean = math.hypot(*sample.offset), self._layer.mean
        if self.config.guards.gate_s == 0 or not math.isfinite(size):
            return state
        bounded = sample.offset * (MAX_SAMPLE_OFFSET_M_S / max(size, MAX_SAMPLE_OFFSET_M_S))
        offset = mean(state.mean_offset, bounded)
        square = mean(state.mean_square_offset, float(bounded @ bounded))
        state = state._replace(mean_offset=offset, mean_square_offset=square)
        if size > MAX_SAMPLE_OFFSET_M_S:
            return state
        target = sample.target - offset
        with np.errstate(over="ignore", invalid="ignore"):
            nominal = float(target @ target)
            offline, learned = (float(e @ e) for e in (c - target for c in sample.corrections))
        advantage = state.mean_advantage
        if math.isfinite(offline + learned):
            advantage = mean(advantage, improvement(offline, learned))
        layers = (
            self._layer.update(layer, nominal, corrected)
            for layer, corrected in zip(state.layers, (offline, learned), strict=True)
        )
        return state._replace(layers=PerLayer(*layers), mean_advantage=advantage)

    def check_statistics(self, state: GateState) -> PerLayer[GateCause]:
        """Returns POISONED, UNHELPFUL or OK for each layer, from the running means."""
        offline, learned = (
            GateCause.UNHELPFUL if self._layer.is_harmful(layer) else GateCause.OK
            for layer in state.layers
        )
        is_used = state.layers.learned.cause == GateCause.OK
        if is_used and self._disadvantage(state) > MAX_DISADVANTAGE:
            learned = GateCause.UNHELPFUL
        if self._offset_ratio(state) > 1:
            learned = GateCause.POISONED
        return PerLayer(offline, learned)

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

    def apply(
        self,
        state: GateState,
        causes: PerLayer[GateCause],
        corrections: PerLayer[np.ndarray],
        last: np.ndarray,
    ) -> tuple[np.ndarray, GateState]:
        """Gates each layer off, for the largest of its causes at this tick, or on.

        Args:
            state: After `update`.
            causes: Cause at this tick to gate each layer off.
            corrections: (3,) m/s, c Delta of each layer at this tick.
            last: (3,) m/s, c Delta used at the tick before.

        Returns:
            (3,) m/s, c Delta to use, and the state after the tick.
        """
        gate, (offline, learned) = self._layer, state.layers
        offline = gate.apply(offline, causes.offline, gate.is_proven(offline))
        state = state._replace(layers=PerLayer(offline, learned))
        layers = PerLayer(offline, gate.apply(learned, causes.learned, self._may_return(state)))
        was_learned = state.blend.source == DeltaSource.LEARNED
        is_harmful = (causes.learned if was_learned else causes.offline) == GateCause.UNHELPFUL
        correction, blend = self._blend.step(
            state.blend, self._source(layers), is_harmful, corrections, last
        )
        # If the learned layer is gated off, the learner restarts from the offline layer.
        advantage = state.mean_advantage if causes.learned == GateCause.OK else 0.0
        return correction, state._replace(layers=layers, blend=blend, mean_advantage=advantage)

    def reported_layer(self, state: GateState) -> LayerState:
        """Returns the state of the learned layer in the mode `online`, else of the offline one."""
        return state.layers.learned if self.config.mode == "online" else state.layers.offline

    def _source(self, layers: PerLayer[LayerState]) -> DeltaSource:
        """Returns the layer to use."""
        if self.config.mode == "online" and layers.learned.cause == GateCause.OK:
            return DeltaSource.LEARNED
        if self.config.mode != "off" and layers.offline.cause == GateCause.OK:
            return DeltaSource.OFFLINE
        return DeltaSource.NONE

    def _may_return(self, state: GateState) -> bool:
        """Returns True if the learned layer is proven, and was not learned from suspect labels."""
        is_poisoned = state.layers.learned.cause == GateCause.POISONED
        is_suspect = is_poisoned and self.rejects_labels(state)
        is_proven = self._layer.is_proven(state.layers.learned)
        return is_proven and not is_suspect and self._disadvantage(state) <= 0

    def _disadvantage(self, state: GateState) -> float:
        """Returns the learned layer's disadvantage; 0 while the offline layer is gated off."""
        return -state.mean_advantage if state.layers.offline.cause == GateCause.OK else 0.0

    def _offset_ratio(self, state: GateState) -> float:
        """Returns the ratio of the labels' mean offset to its bound; 0 without a bound."""
        bound = self.config.guards.max_offset_m_s
        if bound == 0 or self.config.guards.gate_s == 0:
            return 0.0
        # Standard deviation of the mean: position noise is uncorrelated between samples.
        noise = self._layer.sample_weight * math.sqrt(state.mean_square_offset)
        return math.hypot(*state.mean_offset) / (bound + NOISE_DEVIATIONS * noise)
