"""The MPC as a system."""

from __future__ import annotations

import time

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.mpc import MpcFormulation, MpcInputs
from aerodrake.model.qp import CondensedQp, QpStatus
from aerodrake.model.vehicle_state import VehicleState


class MpcSystem(LeafSystem):
    """Predictive kinematic control of the end-effector (paper, algorithm 1).

    Ports:
        in `state` (13 + 2 n): measured state.
        in `end_effector` (abstract): `EndEffector` at that state.
        in `base_setpoint` (9), `joint_setpoint` (3 n): what is commanded now.
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' now and at each stage.
        in `weights` (5): gamma, mode, w_q, w_m, w_d.
        in `delta` (3): m/s, residual velocity.
        out `u` (3 + n): m/s^2 and rad/s^2, accelerations of the setpoints.
        out `prediction` (3 (N + 1)): m, p_E now and as predicted at each stage.
        out `status` (2): a `QpStatus`, and OSQP's iterations.
    State:
        `u`, `plan` (N (3 + n), the scaled inputs of the last plan), `prediction`
        and `status`, of the last tick.
    Rate:
        the equivalent model's period.

    A program that cannot be solved leaves the loop with the last plan, shifted
    by one tick; at its end it runs out into zero acceleration.

    Attributes:
        tick_ms: Wall time of forming and solving at each tick so far. An
            instrument beside the Context: it never feeds back.

    Args:
        formulation: Cost and bounds.
    """

    def __init__(self, formulation: MpcFormulation):
        super().__init__()
        self._formulation = formulation
        self._qp = CondensedQp(formulation.A, formulation.config.max_iterations)
        self.tick_ms: list[float] = []
        N, m = formulation.config.horizon, 3 + formulation.model.joints
        n = formulation.model.joints
        self._inputs = m
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(n))
        self._end_effector = self.DeclareAbstractInputPort(
            "end_effector", AbstractValue.Make(object())
        )
        self._base_setpoint = self.DeclareVectorInputPort("base_setpoint", 9)
        self._joint_setpoint = self.DeclareVectorInputPort("joint_setpoint", 3 * n)
        self._horizon = self.DeclareVectorInputPort("horizon", 6 * (N + 1))
        self._weights = self.DeclareVectorInputPort("weights", 5)
        self._delta = self.DeclareVectorInputPort("delta", 3)
        self._x_u = self.DeclareDiscreteState(np.zeros(m))
        self._x_plan = self.DeclareDiscreteState(np.zeros(N * m))
        self._x_prediction = self.DeclareDiscreteState(np.zeros(3 * (N + 1)))
        self._x_status = self.DeclareDiscreteState(np.zeros(2))
        self.DeclareStateOutputPort("u", self._x_u)
        self.DeclareStateOutputPort("prediction", self._x_prediction)
        self.DeclareStateOutputPort("status", self._x_status)
        self.DeclarePeriodicDiscreteUpdateEvent(formulation.model.dt, 0.0, self._update)

    def tick_inputs(self, context: Context) -> MpcInputs:
        """What the tick at this Context is about."""
        state = VehicleState.from_vector(self._state.Eval(context))
        rates = state.rpy_rates
        _, _, w_q, w_m, w_d = self._weights.Eval(context)
        return MpcInputs(
            x_0=self._formulation.model.initial_state(
                state.p_B,
                state.v_B,
                self._base_setpoint.Eval(context),
                self._joint_setpoint.Eval(context),
            ),
            end_effector=self._end_effector.Eval(context),
            xi_u_rates=rates[:2],
            yaw_rate=rates[2],
            reference=self._horizon.Eval(context).reshape(-1, 6),
            delta=self._delta.Eval(context),
            w_q=w_q,
            w_m=w_m,
            w_d=w_d,
        )

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tick = self.tick_inputs(context)
        last = context.get_discrete_state(self._x_plan).value()
        shifted = np.concatenate([last[self._inputs :], np.zeros(self._inputs)])

        start = time.perf_counter()
        program = self._formulation.form(tick)
        result = self._qp.solve(program.H, program.g, program.lower, program.upper)
        self.tick_ms.append(1e3 * (time.perf_counter() - start))

        plan = shifted if result.status is QpStatus.FAILED else result.z
        U = self._formulation.scale * plan
        prediction = self._formulation.predict(tick, program, U)
        discrete.set_value(self._x_u, U[: self._inputs])
        discrete.set_value(self._x_plan, plan)
        discrete.set_value(self._x_prediction, prediction.ravel())
        discrete.set_value(self._x_status, [result.status, result.iterations])
