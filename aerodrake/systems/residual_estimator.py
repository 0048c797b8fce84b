"""System that estimates the residual of the equivalent model."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.estimation import EstimatorInputs, EstimatorState, ResidualEstimation
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.scenario import Residual
from aerodrake.support.arguments import Timed, checked
from aerodrake.systems.named_state import NamedState

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual.network import ResidualNetwork


class ResidualEstimator(LeafSystem):
    """Estimates Delta of the equivalent model, and learns the network's last layer online.

    Delta is the residual of the model x+ = A x + B u + C Delta. In the models with K_B alone it is
    the paper's residual velocity in m/s, p_B' = K_B (p_d - p_B) + Delta. In the model `flight` it
    is the residual acceleration in m/s^2, p_B'' = b + d + Delta. With c the velocity that a Delta
    of one unit adds in one period (`EquivalentModel.residual_gain`), the label of Delta is the
    measured velocity minus the one predicted without Delta, over c.

    At tick k the measured state completes the sample that began at k-1: the velocity that the
    model predicted from x_{k-1}, Delta_{k-1} and the input applied since then is compared with
    the measured one. First the last layer takes its step (paper, eq. 6; `OnlineLearner`),
    then the network infers Delta_k. (The paper's Algorithm 1 has the reverse order, and learns
    one tick late.) The features of a sample are from t_{k-1}, with the input applied up to then,
    and therefore do not contain its label.

    `LearningGate` uses the Delta of the learned layer while that improves the prediction, else that
    of the offline layer while that does, else zero. If the learned layer is gated off, the
    learner restarts from the offline layer with an empty ring buffer, and keeps learning unless
    labels are rejected. A tick with NaN or infinite inputs neither completes nor begins a
    sample, and its Delta is zero.

    The step of eq. 6 is stable for a learning rate eta < 1 / lambda_max, the largest eigenvalue of
    the mean of phi phi^T over the samples in the ring buffer (`last_layer_step`). With a larger
    one the last layer may diverge; with `as_printed` nothing bounds it, otherwise the guards do.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `x_0` (nx): state of the model at a tick.
        in `base_setpoint` (9): [p_d, v_d, a_d] in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): [q_d, q_d', q_d''] in rad, rad/s, rad/s^2.
            The accelerations are u_{k-1} at a tick: the input applied up to it.
        in `saturated` (1): above 0.5 the flight controller is saturated, and with
            `freeze_saturated` the completed sample is not learned.
        out `delta` (3): m/s or m/s^2 as above, world frame; zero in the mode `off`. It feeds
            through: a consumer that samples it at a tick receives it without delay. Meaningless
            between ticks.
        out `prediction_error` (3): m/s, predicted minus measured velocity of the base, for the
            last completed sample, learned or not; zero before the first.
        out `nominal_prediction_error` (3): m/s, `prediction_error` of the model without Delta.
        out `learner_health` (2): `GateCause` for which the learned layer, in the mode `offline`
            the offline layer, is gated off, and time since then in s; `OK` and 0 while it is used.
        out `delta_source` (1): `DeltaSource`, the layer whose Delta is used.
        out `stable_learning_rate` (1): bound of the learning rate for the samples in the ring
            buffer, below which the step is stable; 0 without samples.
    State:
        discrete, one group for each field of `LearnerState` (last layer, ring buffer, sample
        count), `PendingPrediction`, `PredictionErrors` and `GateState`.
    Rate:
        the period of the model, from time 0.

    Attributes:
        groups: Discrete state, one `NamedState` for each part of `EstimatorState`.

    Args:
        network: Copied; later changes have no effect. None in the mode `off`.
        model: Equivalent model; with the kind `integral`, Delta is zero.
        config: Mode, learning rate, batch, guards and gate; the checkpoint is not read.
    """

    @checked
    def __init__(
        self,
        network: ResidualNetwork | None,
        model: Annotated[EquivalentModel, Timed("dt")],
        config: Residual,
    ):
        super().__init__()
        self._estimation = ResidualEstimation.make(copy.deepcopy(network), model, config)

        n = model.joints
        sizes = EstimatorInputs(VehicleState.size(n), len(model.A), 9, 3 * n, 1)
        for name, size in sizes._asdict().items():
            self.DeclareVectorInputPort(name, size)
        self.groups = EstimatorState(*(NamedState(self, s) for s in self._estimation.start()))

        # The output and the update use the same computation, once a tick.
        self._tick = self.DeclareCacheEntry(
            "tick", ValueProducer(lambda: Value[object](None), self._calc_tick), self._tickets()
        )
        self.DeclareVectorOutputPort("delta", 3, self._calc_delta, {self._tick.ticket()})
        errors = self.groups.errors.groups
        self.DeclareStateOutputPort("prediction_error", errors["error"])
        self.DeclareStateOutputPort("nominal_prediction_error", errors["nominal_error"])
        gate, learner = (
            {self.discrete_state_ticket(group) for group in part.groups.values()}
            for part in (self.groups.gate, self.groups.learner)
        )
        self.DeclareVectorOutputPort("learner_health", 2, self._calc_health, gate)
        self.DeclareStateOutputPort("delta_source", self.groups.gate.groups["blend.source"])
        self.DeclareVectorOutputPort("stable_learning_rate", 1, self._calc_stable_rate, learner)
        self.DeclarePeriodicDiscreteUpdateEvent(model.dt, 0.0, self._update)

    def _tickets(self) -> set[DependencyTicket]:
        """Returns the prerequisites of the computation at a tick."""
        return {self.all_input_ports_ticket(), self.xd_ticket()}

    def _equations(self, context: Context) -> ResidualEstimation:
        """Returns the equations of the current tick."""
        return self._estimation

    def _calc_tick(self, context: Context, tick: AbstractValue) -> None:
        inputs = EstimatorInputs(
            *(self.GetInputPort(name).Eval(context).copy() for name in EstimatorInputs._fields)
        )
        state = EstimatorState(*(part.read(context) for part in self.groups))
        tick.set_value(self._equations(context).tick(state, inputs))

    def _calc_delta(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._tick.Eval(context)[0])

    def _calc_health(self, context: Context, output: BasicVector) -> None:
        state = self._estimation.gate.reported_layer(self.groups.gate.read(context))
        output.set_value(np.array([state.cause, state.gated_s]))

    def _calc_stable_rate(self, context: Context, output: BasicVector) -> None:
        learner = self.groups.learner.read(context)
        output[0] = self._estimation.learner.stable_learning_rate(learner)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        _, state = self._tick.Eval(context)
        for part, values in zip(self.groups, state, strict=True):
            part.write(discrete, values)
