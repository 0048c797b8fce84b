"""Residual velocity of the base, inferred and learned at the rate of the MPC."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace
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

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.features import PHI_SIZE, features
from aerodrake.model.residual.judge import HEALTH_SIZE, Cause, Evidence, Health, LearnerJudge
from aerodrake.model.residual.online_learner import LearnerState, OnlineLearner
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import Residual

if TYPE_CHECKING:  # torch takes a second to import.
    from aerodrake.model.residual.network import ResidualNetwork


@dataclass(frozen=True)
class _Sample:
    """A prediction over one period, and what came of it."""

    phi: np.ndarray  # (33,) when it was made.
    target: np.ndarray  # (3,) m/s, measured velocity minus the model's without Delta.
    correction: np.ndarray  # (3,) m/s, what the network would have added to that.
    error: np.ndarray  # (3,) m/s, predicted minus measured velocity.


@dataclass(frozen=True)
class _Tick:
    """All that one tick computes."""

    sample: _Sample | None  # Completed at this tick.
    learned: LearnerState | None  # From it as well; None in the mode `off`.
    health: Health | None
    x: np.ndarray  # (nx,)
    phi: np.ndarray  # (33,)
    motion: np.ndarray  # (6,) p_B and v_B, as they are learned from.
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

    Delta is what the network says while `LearnerJudge` lets it, and zero otherwise. A
    network that is given up begins again with its offline layer and an empty ring,
    and goes on learning, or not where samples are poisoned, without being heard.

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
        in `fault` (4): what is wrong, as `LearnerFaultSystem` has it; unconnected where
            nothing is.
        out `delta` (3): m/s, world frame; zero in the mode `off`. It feeds
            through, so that whoever samples it at a tick has it without delay;
            between ticks it means nothing.
        out `prediction_error` (3): m/s, predicted minus measured velocity of the
            base, for the last completed sample, learned or not; zero before the
            first.
        out `nominal_prediction_error` (3): the same of the model without Delta.
        out `learner_health` (2): `Cause` for which Delta is held at zero, or on its way
            there, and s for which it has been; `OK` and 0 while it is used.

    State (discrete): last layer (3, 33); rings of phi and target over the last
        `batch` samples learned; number of samples learned; whether a prediction
        is pending (0 or 1), and its x_k, phi_k, motion and Delta; the two prediction
        errors; `Health`, in two groups.

    Rate: the period of the model, from time 0.

    Args:
        network: Copied; later changes to it are not seen. None with the mode `off`.
        model: Whose residual is estimated. With the `integral` kind, where Delta
            has no effect, there is nothing to learn.
        config: Mode, learning rate, batch, guards and judge; the checkpoint is not read.
    """

    def __init__(self, network: ResidualNetwork | None, model: EquivalentModel, config: Residual):
        super().__init__()
        self._network = copy.deepcopy(network)
        self._model = model
        self._gain = model.C[model.base_velocity].diagonal()
        self._mode = config.mode
        theta = np.zeros((3, PHI_SIZE)) if network is None else network.last_layer()
        self._learner = OnlineLearner(config, theta, self._gain)
        self._judge = LearnerJudge(config, theta, model.dt)

        n = model.joints
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._x_0 = self.DeclareVectorInputPort("x_0", len(model.A))
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._saturated = self.DeclareVectorInputPort("saturated", 1)
        self._fault = self.DeclareVectorInputPort("fault", 4)

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
        self._motion = self.DeclareDiscreteState(6)
        self._used = self.DeclareDiscreteState(3)
        health = self._judge.start().to_vector() if network is not None else np.zeros(HEALTH_SIZE)
        self._health = self.DeclareDiscreteState(health[:2])
        self._evidence = self.DeclareDiscreteState(health[2:])

        # The output and the update need the same results: computed once a tick.
        self._tick = self.DeclareCacheEntry(
            "tick",
            ValueProducer(lambda: Value[object](None), self._calc_tick),
            {self.all_input_ports_ticket(), self.xd_ticket()},
        )
        self.DeclareVectorOutputPort("delta", 3, self._calc_delta, {self._tick.ticket()})
        self.DeclareStateOutputPort("prediction_error", self._error)
        self.DeclareStateOutputPort("nominal_prediction_error", self._nominal_error)
        self.DeclareStateOutputPort("learner_health", self._health)
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
        if self._mode == "off":
            sample = self._complete(context, split_state(state)[4], u)
            tick.set_value(_Tick(sample, None, None, x, phi, np.zeros(6), np.zeros(3)))
            return
        fault = self._fault.Eval(context) if self._fault.HasValue(context) else np.zeros(4)
        motion = np.concatenate([split_state(state)[1], split_state(state)[4] + fault[1:]])
        sample = self._complete(context, motion[3:], u)
        health, found, learned = self._known(context), Cause.OK, self._learned(context)
        if sample is not None:
            health = self._judge.weigh(health, self._evidence_of(context, sample, motion))
            found = self._judge.verdict(health)
            if found != Cause.OK:
                learned = self._learner.start()
            elif self._mode == "online" and not self._judge.doubts(health):
                learned = self._learner.step(learned, sample.phi, sample.target, saturated[0] > 0.5)
        learned = replace(learned, theta=learned.theta + fault[0])
        with np.errstate(invalid="ignore"):  # What comes of a layer that is lost is looked at.
            delta = learned.theta @ phi
        found = max(found, self._judge.inspect(learned.theta, delta))
        if found > Cause.POISONED:
            learned = self._learner.start()
        health = self._judge.rule(health, found, self._numbers(context, self._used).copy())
        used = self._judge.used(health, learned.theta @ phi)
        tick.set_value(_Tick(sample, learned, health, x, phi, motion, used))

    def _complete(self, context: Context, v_B: np.ndarray, u: np.ndarray) -> _Sample | None:
        """The sample that began one tick ago, now that `u` was applied and `v_B` measured."""
        if not self._numbers(context, self._pending)[0]:
            return None
        phi = self._numbers(context, self._phi).copy()
        nominal = self._model.next_velocity(self._numbers(context, self._x), u)
        correction = self._gain * (self._layer(context) @ phi)
        if not np.isfinite(correction).all():
            return None
        used = self._gain * self._numbers(context, self._used)
        return _Sample(phi, v_B - nominal, correction, nominal + used - v_B)

    def _evidence_of(self, context: Context, sample: _Sample, motion: np.ndarray) -> Evidence:
        """What a sample says, now that the base's motion is this."""
        p_B, v_B = np.split(self._numbers(context, self._motion), 2)
        displacement = (motion[:3] - p_B) / self._model.dt
        return Evidence(sample.target, sample.correction, (v_B + motion[3:]) / 2 - displacement)

    def _known(self, context: Context) -> Health:
        groups = (self._health, self._evidence)
        return Health.from_vector(np.concatenate([self._numbers(context, g) for g in groups]))

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
            health = tick.health.to_vector()
            state.set_value(self._health, health[:2])
            state.set_value(self._evidence, health[2:])
            state.set_value(self._motion, tick.motion)
            state.set_value(self._used, tick.delta)
        state.set_value(self._x, tick.x)
        state.set_value(self._phi, tick.phi)
        if tick.sample is not None:
            state.set_value(self._error, tick.sample.error)
            state.set_value(self._nominal_error, -tick.sample.target)

    @staticmethod
    def _numbers(context: Context, group: DiscreteStateIndex) -> np.ndarray:
        """A view into the state."""
        return context.get_discrete_state(group).value()
