"""The supervisor as a system."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, InputPort, LeafSystem

from aerodrake.model.sensing.sample_health import split_health
from aerodrake.model.supervision.conditions import (
    Condition,
    ConditionTable,
    FlightStatus,
    Signal,
    SupervisorState,
    compute_signals,
    supervise,
)
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.arguments import Period, checked
from aerodrake.systems.named_state import NamedState

HEALTHY, EFFECTIVE, GATE_OPEN, NO_JOINT = np.zeros(6), np.ones(1), np.zeros(2), np.zeros(1)
"""Values of ports that are not connected."""


class SupervisorSystem(LeafSystem):
    """Monitors the flight, and enters the worst safe mode that an active condition requests.

    Ports:
        in `state` (13 + 2 n): measured `VehicleState`.
        in `specific_thrust` (1): m/s^2, of the flight controller.
        in `status` (3): of the MPC: a `QpStatus`, iterations, ticks since its last solution.
        in `sample_health` (6): s since the last accepted sample of position, attitude, and
            joints; and the verdict on each.
        in `joint_oscillation` (n): rad/s, amplitude with which each joint oscillates.
        in `torque_at_limit` (n): 1 for each joint whose torque is at its limit.
        in `rotor_effectiveness` (k): fraction of its thrust that each rotor gives.
        in `saturated` (1): 1 while the flight controller is saturated.
        in `reference_verdict` (1): a `ReferenceVerdict`.
        in `learner_health` (2): the `GateCause` for which Delta is gated off, or OK; s since then.
        `sample_health`, `joint_oscillation`, `torque_at_limit`, `rotor_effectiveness` and
        `learner_health` may be left unconnected, which means healthy.
        out `mode` (1): a `SafeMode`.
        out `cause` (1): the index of the condition that requests it, -1 for none.
        out `conditions` (K): 1 for active conditions.
    State:
        the fields of `SupervisorState`, a group each.
    Rate:
        `period`, from time 0. One period after STOP begins, a publish event ends the
        simulation (`ReachedTermination`) with the name of the cause.

    Args:
        conditions: The K conditions of `aerodrake.model.supervision.conditions.conditions`.
        vehicle: Its feet and the numbers of its joints and rotors.
        period: s.
        mpc_period: s, between ticks of the MPC.
    """

    @checked
    def __init__(
        self,
        conditions: tuple[Condition, ...],
        vehicle: VehicleModel,
        period: Period,
        mpc_period: Period,
    ):
        super().__init__()
        self._conditions, self._table = conditions, ConditionTable.make(conditions)
        swings = [c.trigger for c in conditions if c.signal == Signal.JOINT_OSCILLATION]
        self._oscillation = min(swings, default=np.inf)
        self._feet, self._period, self._mpc_period = vehicle.feet_m, period, mpc_period
        self._vehicle_state = self.DeclareVectorInputPort(
            "state", VehicleState.size(vehicle.joints)
        )
        self._thrust = self.DeclareVectorInputPort("specific_thrust", 1)
        self._status = self.DeclareVectorInputPort("status", 3)
        self._sample_health = self.DeclareVectorInputPort("sample_health", 6)
        self._joint_oscillation = self.DeclareVectorInputPort("joint_oscillation", vehicle.joints)
        self._torque_at_limit = self.DeclareVectorInputPort("torque_at_limit", vehicle.joints)
        self._effectiveness = self.DeclareVectorInputPort(
            "rotor_effectiveness", len(vehicle.rotors.names)
        )
        self._saturated = self.DeclareVectorInputPort("saturated", 1)
        self._verdict = self.DeclareVectorInputPort("reference_verdict", 1)
        self._learner_health = self.DeclareVectorInputPort("learner_health", 2)
        self._state = NamedState(self, SupervisorState.initial(len(conditions)))
        for port, field in (("mode", "mode"), ("cause", "cause"), ("conditions", "active")):
            self.DeclareStateOutputPort(port, self._state.groups[field])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._end)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last = self._state.read(context)
        _, _, plan_age = self._status.Eval(context)
        learner_cause, _ = self._value(context, self._learner_health, GATE_OPEN)
        health = split_health(self._value(context, self._sample_health, HEALTHY))
        status = FlightStatus(
            state=self._vehicle_state.Eval(context),
            mode=last.mode,
            specific_thrust=self._thrust.Eval(context)[0],
            plan_age=plan_age,
            outage_s=health.ages,
            verdicts=health.verdicts,
            joint_oscillation=self._value(context, self._joint_oscillation, NO_JOINT),
            torque_at_limit=self._value(context, self._torque_at_limit, NO_JOINT),
            rotor_effectiveness=self._value(context, self._effectiveness, EFFECTIVE),
            saturated=self._saturated.Eval(context)[0],
            reference_verdict=self._verdict.Eval(context)[0],
            learner_cause=learner_cause,
        )
        signals = compute_signals(status, self._feet, self._mpc_period, self._oscillation)
        self._state.write(discrete, supervise(self._table, last, signals, self._period))

    def _end(self, context: Context) -> EventStatus:
        state = self._state.read(context)
        if state.mode != SafeMode.STOP:
            return EventStatus.DidNothing()
        return EventStatus.ReachedTermination(self, self._conditions[state.cause].name)

    @staticmethod
    def _value(context: Context, port: InputPort, otherwise: np.ndarray) -> np.ndarray:
        return port.Eval(context) if port.HasValue(context) else otherwise
