"""Residual velocity of the base, inferred and learned at the rate of the MPC."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from typing import Literal

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
from aerodrake.model.last_layer import last_layer_step
from aerodrake.model.residual_network import PHI_SIZE, ResidualNetwork, features
from aerodrake.model.vehicle_state import VehicleState

Mode = Literal["off", "offline", "online"]


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
    theta: np.ndarray  # (3, 33)
    x: np.ndarray  # (nx,)
    phi: np.ndarray  # (33,)
    delta: np.ndarray  # (3,) m/s


class ResidualEstimator(LeafSystem):
    """Delta of the equivalent model, with online learning of the last layer.

    At the tick k the state measured now completes the sample that began at k-1:
    the velocity that the model predicted with x_{k-1}, Delta_{k-1} and the input
    that was applied since is compared with the measured one. First the last
    layer takes its step (paper, eq. 6), then the network infers Delta_k. (The
    paper's Algorithm 1 has it the other way round, and learns a tick late.)

    The label of a sample is never among its features: these are from t_{k-1},
    with the input applied up to then. While fewer than `batch` samples have been
    seen, a step takes the mean over those.

    A tick whose inputs are not finite neither completes nor begins a sample, and
    its Delta is zero, so that nothing of them stays.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `base_setpoint` (9): [p_d, v_d, a_d] in m, m/s, m/s^2, world frame.
        in `joint_setpoint` (3 n): [q_d, q_d', q_d''] in rad, rad/s, rad/s^2.
            The accelerations are u_{k-1} at a tick: the input applied up to it.
        out `delta` (3): m/s, world frame; zero in the mode `off`. It feeds
            through, so that whoever samples it at a tick has it without delay;
            between ticks it means nothing.
        out `prediction_error` (3): m/s, predicted minus measured velocity of the
            base, for the last completed sample; zero before the first.
        out `nominal_prediction_error` (3): the same of the model without Delta.

    State (discrete): last layer (3, 33); rings of phi and target over the last
        `batch` samples; number of samples seen; whether a prediction is pending
        (0 or 1), and its x_k and phi_k; the two prediction errors.

    Rate: the period of the model, from time 0.

    Args:
        network: Copied; later changes to it are not seen.
        model: Whose residual is estimated. With the `integral` kind, where Delta
            has no effect, there is nothing to learn.
        mode: `off`, `offline` (the network as it is) or `online`.
        learning_rate: eta.
        batch: B_l, number of the latest samples in a step.
    """

    def __init__(
        self,
        network: ResidualNetwork,
        model: EquivalentModel,
        mode: Mode,
        learning_rate: float,
        batch: int,
    ):
        super().__init__()
        self._network = copy.deepcopy(network)
        self._model = model
        self._gain = model.C[model.base_velocity].diagonal()
        self._mode = mode
        self._learning_rate = learning_rate
        self._batch = batch

        n = model.joints
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)

        self._theta = self.DeclareDiscreteState(network.last_layer().ravel())
        self._phis = self.DeclareDiscreteState(batch * PHI_SIZE)
        self._targets = self.DeclareDiscreteState(batch * 3)
        self._seen = self.DeclareDiscreteState(1)
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
        state = VehicleState.from_vector(self._state.Eval(context))
        base, arm = self._base_setpoint.Eval(context), self._joint_setpoint.Eval(context)
        u = np.concatenate([base[6:], arm[2 * self._model.joints :]])
        x = self._model.initial_state(state.p_B, state.v_B, base, arm)
        inputs = features(state, u)
        phi = np.zeros(PHI_SIZE) if self._mode == "off" else self._network.phi(inputs)
        if not np.isfinite(np.concatenate([x, inputs, phi])).all():
            tick.set_value(None)
            return
        sample = self._complete(context, state.v_B, u)
        theta = self._learn(context, sample)
        tick.set_value(_Tick(sample, theta, x, phi, theta @ phi))

    def _complete(self, context: Context, v_B: np.ndarray, u: np.ndarray) -> _Sample | None:
        """The sample that began one tick ago, now that `u` was applied and `v_B` measured."""
        if not self._numbers(context, self._pending)[0]:
            return None
        x, phi = self._numbers(context, self._x), self._numbers(context, self._phi).copy()
        nominal = self._model.predict(x, u, np.zeros(3))[self._model.base_velocity]
        delta = self._last_layer(context) @ phi
        return _Sample(phi, v_B - nominal, nominal + self._gain * delta - v_B)

    def _learn(self, context: Context, sample: _Sample | None) -> np.ndarray:
        theta = self._last_layer(context)
        if self._mode != "online" or sample is None:
            return theta.copy()
        seen = int(self._numbers(context, self._seen)[0])
        phis = self._numbers(context, self._phis).reshape(-1, PHI_SIZE).copy()
        targets = self._numbers(context, self._targets).reshape(-1, 3).copy()
        phis[seen % self._batch], targets[seen % self._batch] = sample.phi, sample.target
        held = slice(min(seen + 1, self._batch))
        return last_layer_step(theta, phis[held], targets[held], self._gain, self._learning_rate)

    def _calc_delta(self, context: Context, delta: BasicVector) -> None:
        tick = self._tick.Eval(context)
        delta.set_value(tick.delta if tick else np.zeros(3))

    def _update(self, context: Context, state: DiscreteValues) -> None:
        tick: _Tick | None = self._tick.Eval(context)
        state.set_value(self._pending, [tick is not None])
        if tick is None:
            return
        state.set_value(self._theta, tick.theta.ravel())
        state.set_value(self._x, tick.x)
        state.set_value(self._phi, tick.phi)
        if tick.sample is None:
            return
        seen = state.get_mutable_value(self._seen)
        row = int(seen[0]) % self._batch
        state.get_mutable_value(self._phis).reshape(-1, PHI_SIZE)[row] = tick.sample.phi
        state.get_mutable_value(self._targets).reshape(-1, 3)[row] = tick.sample.target
        seen += 1
        state.set_value(self._error, tick.sample.error)
        state.set_value(self._nominal_error, -tick.sample.target)

    def _last_layer(self, context: Context) -> np.ndarray:
        return self._numbers(context, self._theta).reshape(-1, PHI_SIZE)

    @staticmethod
    def _numbers(context: Context, group: DiscreteStateIndex) -> np.ndarray:
        """A view into the state."""
        return context.get_discrete_state(group).value()
