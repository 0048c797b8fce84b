"""Residual velocity of the base, inferred and learned at the rate of the MPC."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteStateIndex,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.online_learner import LearnerState, OnlineLearner
from aerodrake.model.residual_features import PHI_SIZE, features
from aerodrake.model.vehicle_state import VehicleState, parts
from aerodrake.scenario import Residual

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual_network import ResidualNetwork


@dataclass(frozen=True)
class _Sample:
    """A prediction over one period, and what came of it."""

    phi: np.ndarray  # (33,) when it was made.
    target: np.ndarray  # (3,) m/s, measured velocity minus the model's without Delta.
    error: np.ndarray  # (3,) m/s, predicted minus measured velocity.


@dataclass(frozen=True)
class _Tick:
    """All that one tick computes."""

    sample: _Sample | None  # Completed at this tick.
    learned: LearnerState | None  # From it as well; None where nothing is learned.
    x: np.ndarray  # (nx,)
    phi: np.ndarray  # (33,)
    delta: np.ndarray  # (3,) m/s


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

    State (discrete): last layer (3, 33); rings of phi and target over the last
        `batch` samples learned; number of samples learned; whether a prediction
        is pending (0 or 1), and its x_k and phi_k; the two prediction errors.

    Rate: the period of the model, from time 0.

    Args:
        network: Copied; later changes to it are not seen. None with the mode `off`.
        model: Whose residual is estimated. With the `integral` kind, where Delta
            has no effect, there is nothing to learn.
        config: Mode, learning rate, batch and guards; the checkpoint is not read.
    """

    def __init__(self, network: ResidualNetwork | None, model: EquivalentModel, config: Residual):
        super().__init__()
        self._network = copy.deepcopy(network)
        self._model = model
        self._gain = model.C[model.base_velocity].diagonal()
        self._mode = config.mode
        theta = np.zeros((3, PHI_SIZE)) if network is None else network.last_layer()
        self._learner = OnlineLearner(config, theta, self._gain)

        n = model.joints
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._x_0 = self.DeclareVectorInputPort("x_0", len(model.A))
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._saturated = self.DeclareVectorInputPort("saturated", 1)

        start = self._learner.start()
        self._theta = self.DeclareDiscreteState(start.theta.ravel())
        self._phis = self.DeclareDiscreteState(start.phis.ravel())
        self._targets = self.DeclareDiscreteState(start.targets.ravel())
        self._seen = self.DeclareDiscreteState([start.seen])
        self._pending = self.DeclareDiscreteState(1)
        self._x = self.DeclareDiscreteState(len(model.A))
        self._phi = self.DeclareDiscreteState(PHI_SIZE)
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
        state = self._state.Eval(context)
        base, arm = self._base_setpoint.Eval(context), self._joint_setpoint.Eval(context)
        saturated = self._saturated.Eval(context)
        u = np.concatenate([base[6:], arm[2 * self._model.joints :]])
        x = self._x_0.Eval(context).copy()
        inputs = features(state, u)
        phi = np.zeros(PHI_SIZE) if self._mode == "off" else self._network.phi(inputs)
        if not np.isfinite(np.concatenate([x, inputs, phi, saturated])).all():
            tick.set_value(None)
            return
        sample, learned = self._complete(context, parts(state)[4], u), None
        if sample is not None and self._mode == "online":
            learned = self._learner.step(
                self._learned(context), sample.phi, sample.target, saturated[0] > 0.5
            )
        theta = self._layer(context) if learned is None else learned.theta
        tick.set_value(_Tick(sample, learned, x, phi, theta @ phi))

    def _complete(self, context: Context, v_B: np.ndarray, u: np.ndarray) -> _Sample | None:
        """The sample that began one tick ago, now that `u` was applied and `v_B` measured."""
        if not self._numbers(context, self._pending)[0]:
            return None
        phi = self._numbers(context, self._phi).copy()
        nominal = self._model.next_velocity(self._numbers(context, self._x), u)
        delta = self._layer(context) @ phi
        return _Sample(phi, v_B - nominal, nominal + self._gain * delta - v_B)

    def _layer(self, context: Context) -> np.ndarray:
        """(3, 33), theta of the tick before."""
        return self._numbers(context, self._theta).reshape(-1, PHI_SIZE)

    def _learned(self, context: Context) -> LearnerState:
        """Copied from the state: what is computed of it outlives the context's numbers."""
        theta, phis, targets, seen = (
            self._numbers(context, group).copy()
            for group in (self._theta, self._phis, self._targets, self._seen)
        )
        return LearnerState(
            theta.reshape(-1, PHI_SIZE),
            phis.reshape(-1, PHI_SIZE),
            targets.reshape(-1, len(self._gain)),
            int(seen[0]),
        )

    def _calc_delta(self, context: Context, delta: BasicVector) -> None:
        tick = self._tick.Eval(context)
        delta.set_value(tick.delta if tick else np.zeros(3))

    def _update(self, context: Context, state: DiscreteValues) -> None:
        tick: _Tick | None = self._tick.Eval(context)
        state.set_value(self._pending, [tick is not None])
        if tick is None:
            return
        if tick.learned is not None:
            state.set_value(self._theta, tick.learned.theta.ravel())
            state.set_value(self._phis, tick.learned.phis.ravel())
            state.set_value(self._targets, tick.learned.targets.ravel())
            state.set_value(self._seen, [tick.learned.seen])
        state.set_value(self._x, tick.x)
        state.set_value(self._phi, tick.phi)
        if tick.sample is not None:
            state.set_value(self._error, tick.sample.error)
            state.set_value(self._nominal_error, -tick.sample.target)

    @staticmethod
    def _numbers(context: Context, group: DiscreteStateIndex) -> np.ndarray:
        """A view into the state."""
        return context.get_discrete_state(group).value()
