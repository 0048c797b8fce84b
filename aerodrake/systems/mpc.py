"""The MPC as a system."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues

from aerodrake.model.mpc.fault import MpcFault, spoiled
from aerodrake.model.mpc.formulation import MpcFormulation, MpcProgram
from aerodrake.model.mpc.inputs import MpcInputs
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.qp.condensed_qp import QpResult, QpStatus, is_answer, is_bound
from aerodrake.systems.kinematic_controller import KinematicController


class MpcSystem(KinematicController):
    """Predictive kinematic control of the end-effector (paper, algorithm 1).

    Ports:
        those of every `KinematicController`, and
        in `pointing` (abstract): `Pointing`; unconnected where the tool may point
            where it likes.
        in `fault` (2): an `MpcFault`, and iterations of OSQP that are left where it is
            STARVED; unconnected where there is none.
    State:
        beside theirs, `plan` (T (3 + n), m/s^2 and rad/s^2, the inputs of the last plan at
        each of the T ticks of the horizon), and `active`, the bounds that held it, as
        `QpResult` has them, from which the next tick's are looked for.
    Rate:
        the equivalent model's period.

    A program that cannot be solved, or a tick that is missed, leaves the loop with the last
    plan, shifted by one tick; at its end it runs out into zero acceleration.

    Args:
        formulation: Cost and bounds.
    """

    def __init__(self, formulation: MpcFormulation):
        super().__init__(formulation.model, formulation.config.horizon)
        self._formulation = formulation
        self._pointing = self.DeclareAbstractInputPort("pointing", AbstractValue.Make(object()))
        self._fault = self.DeclareVectorInputPort("fault", 2)
        self._solver = MpcSolver(formulation)
        self._inputs = 3 + formulation.model.joints
        self._starts = np.cumsum([0, *formulation.stage_ticks[:-1]])  # Of the stages, in ticks.
        self._x_plan = self.DeclareDiscreteState(
            np.zeros(sum(formulation.stage_ticks) * self._inputs)
        )
        self.DeclareStateOutputPort("plan", self._x_plan)
        self._x_active = self.DeclareDiscreteState(sum(formulation.A.shape))

    def tick_inputs(self, context: Context) -> MpcInputs:
        """What the tick at this Context is about."""
        tick = super().tick_inputs(context)
        if self._pointing.HasValue(context):
            tick = replace(tick, pointing=self._pointing.Eval(context))
        return tick

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tick = self.tick_inputs(context)
        fault, iterations = MpcFault.NONE, 0
        if self._fault.HasValue(context):
            fault, iterations = self._fault.Eval(context)
        start = time.perf_counter()
        program = self._formulation.form(tick)
        result = self._solve(context, program, fault, iterations)
        if fault != MpcFault.MISSED:
            self.tick_ms.append(1e3 * (time.perf_counter() - start))

        if is_answer(result.status):
            stages = self._formulation.inputs(result.z)
            plan = np.repeat(stages, self._formulation.stage_ticks, axis=0)
        else:
            last = context.get_discrete_state(self._x_plan).value().reshape(-1, self._inputs)
            plan = np.vstack([last[1:], np.zeros(self._inputs)])
        U = plan[self._starts]
        prediction = self._formulation.predict(tick, program, U)
        discrete.set_value(self._x_plan, plan.ravel())
        if is_bound(result.status):  # Else nobody asks which they are.
            discrete.set_value(self._x_active, result.active)
        self._command(context, discrete, U[0], prediction, result.status, result.iterations)

    def _solve(
        self, context: Context, program: MpcProgram, fault: float, iterations: float
    ) -> QpResult:
        if fault == MpcFault.MISSED:
            return QpResult(np.zeros_like(program.g), QpStatus.MISSED, 0, np.zeros(0))
        active = None
        if is_bound(context.get_discrete_state(self._x_status).value()[0]):
            active = context.get_discrete_state(self._x_active).value().astype(np.int64)
        budget = int(iterations) if fault == MpcFault.STARVED else None
        return self._solver.solve(spoiled(program, fault), active, budget)
