"""MPC as a system."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues

from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs, TickStatus
from aerodrake.model.qp.condensed_qp import QpResult, is_constrained, is_solved
from aerodrake.systems.kinematic_controller import KinematicController
from aerodrake.systems.named_state import NamedState


class PlanState(NamedTuple):
    """Further discrete state of an `MpcSystem`: plan (T, 3 + n) and active (nz + rows,)."""

    plan: np.ndarray
    active: np.ndarray


class SolvedProgram(NamedTuple):
    """Program of one tick and its solution."""

    program: MpcProgram
    result: QpResult


class MpcSystem(KinematicController):
    """Predictive kinematic control of the end-effector (paper, algorithm 1).

    Ports:
        those of `KinematicController`, and
        in `pointing` (abstract): `Pointing`; unconnected without an orientation task.
    State:
        that of `KinematicController`, `plan` (T (3 + n), m/s^2 and rad/s^2, planned inputs
        at the T ticks of the horizon), and `active` (nz + rows), the last active set as in
        `QpResult`, from which the solver starts at the next tick.
    Rate:
        period of the equivalent model, `rates.mpc_period_s` of a scenario, 20 ms by default.

    If a program is not solved, the last plan is followed, shifted by one tick and extended
    with zero acceleration.

    Args:
        formulation: Cost and bounds.
    """

    def __init__(self, formulation: MpcFormulation):
        super().__init__(formulation.model, formulation.config.horizon)
        self.formulation = formulation
        self._pointing = self.DeclareAbstractInputPort("pointing", AbstractValue.Make(object()))
        self._solver = MpcSolver(formulation)
        self._starts = np.cumsum([0, *formulation.stage_ticks[:-1]])  # Ticks of stage starts.
        self._planned = NamedState(
            self,
            PlanState(
                plan=np.zeros((sum(formulation.stage_ticks), 3 + formulation.model.joints)),
                active=np.zeros(sum(formulation.A.shape)),
            ),
        )
        self.DeclareStateOutputPort("plan", self._planned.groups["plan"])

    def tick_inputs(self, context: Context) -> MpcInputs:
        tick = super().tick_inputs(context)
        if self._pointing.HasValue(context):
            tick = replace(tick, pointing=self._pointing.Eval(context))
        return tick

    def solve_tick(self, context: Context, tick: MpcInputs) -> SolvedProgram:
        program = self.formulation.form(tick)
        return SolvedProgram(program, self._solve(context, program))

    def _solve(self, context: Context, program: MpcProgram) -> QpResult:
        """Solves a program, from the active set of the last tick if it had one."""
        last = TickStatus(*self._last.read(context).status)
        active = None
        if is_constrained(last.status):
            active = self._planned.read(context).active.astype(np.int64)
        return self._solver.solve(program, active)

    def _apply(
        self, context: Context, discrete: DiscreteValues, tick: MpcInputs, solution: SolvedProgram
    ) -> None:
        program, result = solution
        plan, active = self._planned.read(context)
        if is_solved(result.status):
            stages = self.formulation.inputs(result.z)
            plan = np.repeat(stages, self.formulation.stage_ticks, axis=0)
        else:
            plan = np.vstack([plan[1:], np.zeros_like(plan[:1])])
        if is_constrained(result.status):
            active = result.active
        self._planned.write(discrete, PlanState(plan, active))
        U = plan[self._starts]
        prediction = self.formulation.predict(tick, program, U)
        self._set_outputs(context, discrete, U[0], prediction, result.status, result.iterations)
