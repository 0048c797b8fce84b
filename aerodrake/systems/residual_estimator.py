"""Residual velocity of the base, inferred and learned at the rate of the MPC."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.hidden_layers import HiddenLayers
from aerodrake.model.online_learner import LearnerState, OnlineLearner
from aerodrake.model.residual_features import feature_names
from aerodrake.model.residual_tick import VelocityModel, residual_tick
from aerodrake.model.vehicle_state import VehicleState
from aerodrake.scenario import Residual

if TYPE_CHECKING:  # It needs torch, which takes a second to import.
    from aerodrake.model.residual_network import ResidualNetwork


class _Tick(NamedTuple):
    """All that one tick computes."""

    begun: np.ndarray  # The next `pending`.
    errors: np.ndarray | None  # (6,) m/s, of the prediction that was; None without one.
    learned: LearnerState | None  # None without a network.


class ResidualEstimator(LeafSystem):
    """Delta of the equivalent model, with online learning of the last layer.

    At the tick k the state measured now completes the sample that began at k-1:
    the velocity that the model predicted with x_{k-1}, Delta_{k-1} and the input
    that was applied since is compared with the measured one. First the last
    layer takes its step (paper, eq. 6; `OnlineLearner`), then the network infers
    Delta_k. (The paper's Algorithm 1 has it the other way round, and learns a
    tick late.)

    The label of a sample is never among its features: these are from t_{k-1},
    with the input applied up to then. While fewer than `batch` samples have been
    seen, a step takes the mean over those.

    A tick whose inputs are not finite neither completes nor begins a sample, and
    its Delta is zero, so that nothing of them stays.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `x_0` (nx): state of the model at a tick.
        in `base_setpoint` (9): [p_d, v_d, a_d] in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): [q_d, q_d', q_d''] in rad, rad/s, rad/s^2.
            The accelerations are u_{k-1} at a tick: the input applied up to it.
        in `saturated` (1): above 0.5 the flight controller is, and the sample
            that is completed can be one not to learn from.
        out `delta` (3): m/s, world frame; zero in the mode `off`. It feeds
            through, so that whoever samples it at a tick has it without delay;
            between ticks it means nothing.
        out `prediction_error` (3): m/s, predicted minus measured velocity of the
            base, for the last completed sample, learned or not; zero before the
            first.
        out `nominal_prediction_error` (3): the same of the model without Delta.

    State (discrete): `learned`, the last layer (3, h + 1), rings of phi and target over
        the last `batch` samples learned, and how many were; `pending`, whether a
        prediction is (0 or 1), and its x_k, phi_k and Delta_k; the two prediction errors.

    Rate: the period of the model, from time 0.

    Args:
        network: Copied; later changes to it are not seen. Not needed in the mode `off`.
        model: Whose residual is estimated. With the `integral` kind, where Delta
            has no effect, there is nothing to learn.
        config: Mode, learning rate, batch and guards; the checkpoint is not read.
    """

    def __init__(self, network: ResidualNetwork | None, model: EquivalentModel, config: Residual):
        super().__init__()
        n, nx = model.joints, len(model.A)
        if network is None or config.mode == "off":
            self._layers = HiddenLayers.none(len(feature_names(n)))
            theta = np.zeros((3, 1))
        else:
            self._layers, theta = network.hidden_layers(), network.last_layer()
        self._model = VelocityModel.of(model)
        self._learns = config.mode == "online"
        self._learner = OnlineLearner(config, theta, self._model.gain)

        # In the order in which `residual_tick` takes them.
        self._inputs = [
            self.DeclareVectorInputPort(name, size)
            for name, size in (
                ("state", VehicleState.size(n)),
                ("x_0", nx),
                ("base_setpoint", 9),
                ("joint_setpoint", 3 * n),
                ("saturated", 1),
            )
        ]
        self._learned = self.DeclareDiscreteState(self._learner.start().to_vector())
        self._pending = self.DeclareDiscreteState(np.zeros(1 + nx + theta.shape[1] + 3))
        self._error = self.DeclareDiscreteState(3)
        self._nominal_error = self.DeclareDiscreteState(3)

        # The output and the update need the same results: computed once a tick.
        self._tick = self.DeclareCacheEntry(
            "tick",
            ValueProducer(lambda: Value[object](None), self._calc_tick),
            {self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclareVectorOutputPort("delta", 3, self._calc_delta, {self._tick.ticket()})
        self.DeclareStateOutputPort("prediction_error", self._error)
        self.DeclareStateOutputPort("nominal_prediction_error", self._nominal_error)
        self.DeclarePeriodicDiscreteUpdateEvent(model.dt, 0.0, self._update)

    def _calc_tick(self, context: Context, tick: AbstractValue) -> None:
        inputs = [port.Eval(context) for port in self._inputs]
        pending = context.get_discrete_state(self._pending).value()
        begun, errors = residual_tick(self._layers, self._model, pending, *inputs)
        if not begun[0]:
            tick.set_value(_Tick(np.zeros(len(begun)), None, None))
            return
        was_pending, nx = pending[0], len(inputs[1])
        learned = None
        if len(self._layers.b_2):
            learned = self._learner.state_of(context.get_discrete_state(self._learned).value())
            if self._learns and was_pending:
                phi, target = pending[1 + nx : -3], -errors[3:]
                learned = self._learner.step(learned, phi, target, inputs[-1][0] > 0.5)
            begun[-3:] = learned.theta @ begun[1 + nx : -3]
        tick.set_value(_Tick(begun, errors if was_pending else None, learned))

    def _calc_delta(self, context: Context, delta: BasicVector) -> None:
        delta.set_value(self._tick.Eval(context).begun[-3:])

    def _update(self, context: Context, state: DiscreteValues) -> None:
        tick: _Tick = self._tick.Eval(context)
        state.set_value(self._pending, tick.begun)
        if tick.errors is not None:
            state.set_value(self._error, tick.errors[:3])
            state.set_value(self._nominal_error, tick.errors[3:])
            if self._learns:
                state.set_value(self._learned, tick.learned.to_vector())
