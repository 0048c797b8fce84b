"""One tick of the residual estimator, as a pure function of its inputs and state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, NamedTuple, Self

import numpy as np

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.delta_blend import PerLayer
from aerodrake.model.residual.features import PHI_SIZE, features
from aerodrake.model.residual.gate import GateState, LearningGate, VelocitySample
from aerodrake.model.residual.layer_gate import GateCause
from aerodrake.model.residual.online_learner import LearnerState, OnlineLearner
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Residual

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual.network import ResidualNetwork


class EstimatorInputs(NamedTuple):
    """Values of the input ports of `ResidualEstimator`, whose docstring describes them.

    state (13 + 2 n,), x_0 (nx,), base_setpoint (9,), joint_setpoint (3 n,), saturated (1,).
    """

    state: np.ndarray
    x_0: np.ndarray
    base_setpoint: np.ndarray
    joint_setpoint: np.ndarray
    saturated: np.ndarray


class PendingPrediction(NamedTuple):
    """Prediction made at one tick, which the next tick compares with its measurement.

    Attributes:
        is_pending: False if there is no prediction to compare.
        x: (nx,) state of the model at that tick.
        phi: (33,) last hidden activations and a 1.
        p_B, v_B: (3,) m and m/s, measured position and velocity of the base.
        correction: (3,) m/s, c Delta as used.
    """

    is_pending: bool
    x: np.ndarray
    phi: np.ndarray
    p_B: np.ndarray
    v_B: np.ndarray
    correction: np.ndarray


class PredictionErrors(NamedTuple):
    """Predicted minus measured velocity, for the last prediction that was compared.

    error (3,) m/s: with the Delta that was used. nominal_error (3,) m/s: without Delta.
    """

    error: np.ndarray
    nominal_error: np.ndarray


class EstimatorState(NamedTuple):
    """Discrete state of `ResidualEstimator`."""

    learner: LearnerState
    prediction: PendingPrediction
    errors: PredictionErrors
    gate: GateState


@dataclass(frozen=True, eq=False)
class ResidualEstimation:
    """Equations of the residual estimator: learning and inference at one tick.

    Network and output are in Delta's unit. Learner and gate have the velocity correction c Delta
    in m/s, with c the model's `residual_gain`: the label of Delta is the measured velocity minus
    the one predicted without Delta, over c. The integral model has c = 0 and therefore
    no labels; its mode is always `off`.

    Attributes:
        network: Not used in the mode `off`.
        model: Its prediction error is learned.
        mode: In `offline`, the last layer is not updated; in `off`, Delta is zero.
        learner: Updates the last layer.
        gate: Decides which layer is used and whether labels are learned.
    """

    network: ResidualNetwork | None
    model: EquivalentModel
    mode: Literal["off", "offline", "online"]
    learner: OnlineLearner
    gate: LearningGate

    @classmethod
    def make(
        cls, network: ResidualNetwork | None, model: EquivalentModel, config: Residual
    ) -> Self:
        """Makes the equations of the configured learner and gate."""
        if not model.residual_gain.all():
            config = replace(config, mode="off")
        theta = np.zeros((3, PHI_SIZE))
        if config.mode != "off":
            theta = model.residual_gain[:, None] * network.last_layer()
        learner, gate = OnlineLearner(config, theta), LearningGate(config, theta, model.dt)
        return cls(network, model, config.mode, learner, gate)

    def start(self) -> EstimatorState:
        """Returns the state before the first tick."""
        x, phi, zero = np.zeros(len(self.model.A)), np.zeros(PHI_SIZE), np.zeros(3)
        prediction = PendingPrediction(False, x, phi, zero, zero, zero)
        errors = PredictionErrors(zero, zero)
        return EstimatorState(self.learner.start(), prediction, errors, self.gate.start())

    def tick(
        self, state: EstimatorState, inputs: EstimatorInputs
    ) -> tuple[np.ndarray, EstimatorState]:
        """Learns from the pending prediction, then infers Delta.

        A tick with NaN or infinite inputs returns a zero Delta and discards the
        pending prediction; the rest of the state is unchanged.

        Returns:
            Delta to use (3,), in the model's unit, and the state after the tick.
        """
        vehicle, n = split_state(inputs.state), self.model.joints
        u = np.concatenate([inputs.base_setpoint[6:], inputs.joint_setpoint[2 * n :]])
        s = features(inputs.state, u)
        phi = np.zeros(PHI_SIZE) if self.mode == "off" else self.network.phi(s)
        if not np.isfinite(np.concatenate([inputs.x_0, s, phi, inputs.saturated])).all():
            prediction = state.prediction._replace(is_pending=False)
            return np.zeros(3), state._replace(prediction=prediction)
        p_B, v_B = vehicle.p_B, self.label_velocity(vehicle)
        sample, errors = self._complete(state, p_B, v_B, u)
        learner, gate = state.learner, state.gate
        correction, delta = np.zeros(3), np.zeros(3)
        if self.mode != "off":
            learner, gate, causes = self.learn(state, sample, bool(inputs.saturated[0] > 0.5))
            thetas = PerLayer(self.learner.theta_offline, learner.theta)
            with np.errstate(over="ignore", invalid="ignore"):  # The check rejects NaN.
                corrections = PerLayer(*(theta @ phi for theta in thetas))
            causes = PerLayer(*map(max, causes, map(self.gate.check_layer, thetas, corrections)))
            if causes.learned > GateCause.POISONED:
                learner = self.learner.start()
            last = state.prediction.correction
            correction, gate = self.gate.apply(gate, causes, corrections, last)
            delta = correction / self.model.residual_gain
        prediction = PendingPrediction(True, inputs.x_0, phi, p_B, v_B, correction)
        return delta, EstimatorState(learner, prediction, errors, gate)

    def label_velocity(self, vehicle: VehicleState) -> np.ndarray:
        """Returns the measured v_B, (3,) m/s, that labels a sample."""
        return vehicle.v_B

    def learn(
        self, state: EstimatorState, sample: VelocitySample | None, is_saturated: bool
    ) -> tuple[LearnerState, GateState, PerLayer[GateCause]]:
        """Updates gate and last layer by a sample, if any; also returns each layer's cause."""
        learner, gate = state.learner, state.gate
        if sample is None:
            return learner, gate, PerLayer(GateCause.OK, GateCause.OK)
        gate = self.gate.update(gate, sample)
        causes = self.gate.check_statistics(gate)
        if causes.learned != GateCause.OK:
            learner = self.learner.start()
        elif self.mode == "online" and not self.gate.rejects_labels(gate):
            learner = self.learner.step(learner, state.prediction.phi, sample.target, is_saturated)
        return learner, gate, causes

    def _complete(
        self, state: EstimatorState, p_B: np.ndarray, v_B: np.ndarray, u: np.ndarray
    ) -> tuple[VelocitySample | None, PredictionErrors]:
        """Compares the pending prediction with the motion measured now, after `u` was applied."""
        prediction = state.prediction
        if not prediction.is_pending:
            return None, state.errors
        nominal = self.model.next_velocity(prediction.x, u)
        thetas = PerLayer(self.learner.theta_offline, state.learner.theta)
        corrections = PerLayer(*(theta @ prediction.phi for theta in thetas))
        if not np.isfinite(corrections.learned).all():
            return None, state.errors
        offset = (prediction.v_B + v_B) / 2 - (p_B - prediction.p_B) / self.model.dt
        target = v_B - nominal
        error = nominal + prediction.correction - v_B
        return VelocitySample(target, corrections, offset), PredictionErrors(error, -target)
