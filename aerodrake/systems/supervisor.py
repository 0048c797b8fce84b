"""What watches a flight and says in which mode it goes on."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    EventStatus,
    InputPort,
    LeafSystem,
)

from aerodrake.model.supervision.conditions import Condition, Rules, signals, supervise
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel

WELL, GIVING = np.zeros(6), np.ones(1)
"""What a port without a connection says."""


class SupervisorSystem(LeafSystem):
    """Conditions with trigger and clear rules, and the worst mode that one of them asks for.

    Ports:
        in `state` (13 + 2 n): measured state.
        in `specific_thrust` (1): m/s^2, of the flight controller.
        in `status` (3): of the MPC: a `QpStatus`, iterations, ticks since its last answer.
        in `sample_health` (6): s since the last sample that was taken in, of position,
            attitude, and joints; and what was the matter with each.
        in `rotor_effectiveness` (k): share of its thrust that each rotor gives.
        in `saturated` (1): 1 while the flight controller is.
        in `reference_verdict` (1): a `ReferenceVerdict`.
        in `learner_health` (2): what is the matter with the last layer; s for which Delta
            has been held at zero.
        `sample_health`, `rotor_effectiveness` and `learner_health` may be left unconnected by
        who has nothing to tell: then all is well.
        out `mode` (1): a `SafeMode`.
        out `cause` (1): the index of the condition that asks for it, -1 for none.
        out `conditions` (K): 1 where a condition is active.
    State:
        each output; and (K) s for which each condition's signal has asked for a change.
    Rate:
        `period`, from time 0. In STOP a Simulator that steps it reaches termination, a
        period later, and says why.

    Args:
        conditions: K of them, as `aerodrake.model.supervision.conditions.conditions` has them.
        vehicle: Where its feet are.
        period: s.
        mpc_period: s, between ticks of the MPC.
    """

    def __init__(
        self,
        conditions: tuple[Condition, ...],
        vehicle: VehicleModel,
        period: float,
        mpc_period: float,
    ):
        super().__init__()
        self._conditions, self._rules = conditions, Rules.of(conditions)
        self._feet, self._period, self._mpc_period = vehicle.feet_m, period, mpc_period
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(vehicle.joints))
        self._thrust = self.DeclareVectorInputPort("specific_thrust", 1)
        self._status = self.DeclareVectorInputPort("status", 3)
        self._sample_health = self.DeclareVectorInputPort("sample_health", 6)
        self._effectiveness = self.DeclareVectorInputPort(
            "rotor_effectiveness", len(vehicle.rotors.names)
        )
        self._saturated = self.DeclareVectorInputPort("saturated", 1)
        self._verdict = self.DeclareVectorInputPort("reference_verdict", 1)
        self._learner_health = self.DeclareVectorInputPort("learner_health", 2)
        K = len(conditions)
        self._mode = self.DeclareDiscreteState(1)
        self._cause = self.DeclareDiscreteState([-1.0])
        self._active = self.DeclareDiscreteState(K)
        self._since = self.DeclareDiscreteState(K)
        self.DeclareStateOutputPort("mode", self._mode)
        self.DeclareStateOutputPort("cause", self._cause)
        self.DeclareStateOutputPort("conditions", self._active)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._end)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last = context.get_discrete_state()
        watched = signals(
            self._state.Eval(context),
            self._feet,
            last.value(self._mode)[0],
            self._thrust.Eval(context)[0],
            self._status.Eval(context)[2],
            self._mpc_period,
            self._told(context, self._sample_health, WELL)[:3],
            self._told(context, self._effectiveness, GIVING),
            self._saturated.Eval(context)[0],
            self._verdict.Eval(context)[0],
            self._told(context, self._learner_health, WELL)[0],
        )
        mode, cause, active, since = supervise(
            self._rules, last.value(self._active), last.value(self._since), watched, self._period
        )
        discrete.set_value(self._mode, [mode])
        discrete.set_value(self._cause, [cause])
        discrete.set_value(self._active, active)
        discrete.set_value(self._since, since)

    def _end(self, context: Context) -> EventStatus:
        state = context.get_discrete_state()
        if state.value(self._mode)[0] != SafeMode.STOP:
            return EventStatus.DidNothing()
        cause = self._conditions[int(state.value(self._cause)[0])]
        return EventStatus.ReachedTermination(self, cause.name)

    @staticmethod
    def _told(context: Context, port: InputPort, otherwise: np.ndarray) -> np.ndarray:
        return port.Eval(context) if port.HasValue(context) else otherwise
