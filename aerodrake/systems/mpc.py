"""MPC as a system."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues

from aerodrake.model.mpc.custom_terms import CustomTerm
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.solver import MpcSolver
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import QpResult, is_solved
from aerodrake.support.arguments import checked
from aerodrake.systems.kinematic_controller import KinematicController
from aerodrake.systems.named_state import NamedState


class PlanState(NamedTuple):
    """Further discrete state of an `MpcSystem`: plan (T, 3 + n)."""

    plan: np.ndarray


class SolvedProgram(NamedTuple):
    """Program of one tick and its solution."""

    program: MpcProgram
    result: QpResult


class MpcSystem(KinematicController):
    """Predictive kinematic control of the end-effector (paper, algorithm 1).

    Ports:
        those of `KinematicController`, and
        in `pointing` (abstract): `Pointing`; unconnected without an orientation task.
        out `plan` (T (3 + n)): m/s^2 and rad/s^2, planned inputs at the T ticks of the horizon.
    State:
        `u`, `prediction`, `status`, `weights` and `delta`, of the last tick, and `plan`.
    Rate:
        period of the equivalent model, `rates.mpc_period_s` of a scenario, 20 ms by default.

    If a program is not solved, the last plan is followed, shifted by one tick and extended
    with zero acceleration.

    Args:
        formulation: Forms the program of each tick.
        solver: Solves it; None for the solver of the formulation's configuration.
    """

    @checked
    def __init__(self, formulation: MpcFormulation, solver: MpcSolver | None = None):
        super().__init__(formulation.model, formulation.config.horizon)
        self.formulation = formulation
        self._pointing = self.DeclareAbstractInputPort("pointing", AbstractValue.Make(object()))
        self._solver = solver or MpcSolver.make(formulation, formulation.config)
        self._starts = np.cumsum([0, *formulation.stage_ticks[:-1]])  # Ticks of stage starts.
        plan = np.zeros((sum(formulation.stage_ticks), 3 + formulation.model.joints))
        self._planned = NamedState(self, PlanState(plan))
        self.DeclareStateOutputPort("plan", self._planned.groups["plan"])

    def extended(self, *terms: CustomTerm) -> "MpcSystem":
        """Returns the same system with further costs and constraints.

        Raises:
            BadInput: if a term does not fit.
        """
        return MpcSystem(self.formulation.extended(*terms))

    def tick_inputs(self, context: Context) -> MpcInputs:
        tick = super().tick_inputs(context)
        if self._pointing.HasValue(context):
            tick = replace(tick, pointing=self._pointing.Eval(context))
        return tick

    def solve_tick(self, context: Context, tick: MpcInputs) -> SolvedProgram:
        program = self.formulation.form(tick)
        return SolvedProgram(program, self._solve(context, program))

    def _solve(self, context: Context, program: MpcProgram) -> QpResult:
        return self._solver.solve(program)

    def _apply(
        self, context: Context, discrete: DiscreteValues, tick: MpcInputs, solution: SolvedProgram
    ) -> None:
        program, result = solution
        if is_solved(result.status):
            stages = self.formulation.inputs(result.z)
            plan = np.repeat(stages, self.formulation.stage_ticks, axis=0)
        else:
            plan = self._planned.read(context).plan
            plan = np.vstack([plan[1:], np.zeros_like(plan[:1])])
        self._planned.write(discrete, PlanState(plan))
        U = plan[self._starts]
        prediction = self.formulation.predict(tick, program, U)
        self._set_outputs(context, discrete, U[0], prediction, result.status, result.iterations)
