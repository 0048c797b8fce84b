"""Samples and ticks for tests of the learning gate."""

from dataclasses import replace

import numpy as np

from aerodrake.model.residual.delta_blend import PerLayer
from aerodrake.model.residual.gate import (
    GateState,
    LearningGate,
    VelocitySample,
)
from aerodrake.model.residual.layer_gate import (
    GateCause,
    LayerState,
)
from aerodrake.scenario import Residual

DT, M = 0.02, 5
SECOND = round(1 / DT)
ZERO = np.zeros(3)
FINE = PerLayer(GateCause.OK, GateCause.OK)
RIGHT = np.array([0.01, -0.005, 0.0])


def sample(target, learned, offset=ZERO, offline=None) -> VelocitySample:
    """Returns a sample; by default the offline layer is wrong, and never used."""
    offline = -3 * target if offline is None else offline
    return VelocitySample(target, PerLayer(offline, learned), offset)


EXACT = sample(RIGHT, RIGHT)


def make_gate(**changes) -> LearningGate:
    theta = np.random.default_rng(1).normal(size=(3, M))
    return LearningGate(replace(Residual(mode="online"), **changes), theta, DT)


def step(gate: LearningGate, state: GateState, one: VelocitySample) -> GateState:
    """Returns the state after a tick whose last layers pass their check."""
    state = gate.update(state, one)
    return gate.apply(state, gate.check_statistics(state), PerLayer(ZERO, ZERO), ZERO)[1]


def run(gate: LearningGate, samples, state: GateState | None = None) -> list[GateState]:
    """Returns the state after each sample, from the start or from `state`."""
    state, states = gate.start() if state is None else state, []
    for one in samples:
        state = step(gate, state, one)
        states.append(state)
    return states


def learned(state: GateState) -> LayerState:
    return state.layers.learned


def cause(state: GateState) -> GateCause:
    """Returns the learned layer's."""
    return state.layers.learned.cause


def weight(state: GateState) -> float:
    """Returns the learned layer's."""
    return state.blend.weights.learned


def is_finite(state: tuple) -> bool:
    return all(is_finite(v) if isinstance(v, tuple) else np.isfinite(v).all() for v in state)
