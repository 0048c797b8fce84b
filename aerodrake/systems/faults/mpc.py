"""MPC with faults, in place of `MpcSystem` if a scenario has MPC faults."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from aerodrake.model.mpc.custom_terms import CustomTerm
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.program import MpcProgram
from aerodrake.model.mpc.tick import MISSED
from aerodrake.model.qp.result import QpResult
from aerodrake.model.qp.solvers import make_solver
from aerodrake.scenario import (
    AnyFault,
    MpcFault,
    MpcInfeasible,
    MpcMissed,
    MpcNonFinite,
    MpcStarved,
)
from aerodrake.support.arguments import Duration, checked
from aerodrake.systems.mpc import MpcSystem, SolvedProgram

SEVERITY = (MpcStarved, MpcInfeasible, MpcNonFinite, MpcMissed)
"""Kinds of MPC faults, the most severe last: of several active faults that one acts."""


class FaultyMpc(MpcSystem):
    """MPC with faults, each active from its start until before its end.

    A missed tick has status `MISSED` and solves no program.

    Ports:
        those of `MpcSystem`.
    State:
        `u`, `prediction`, `status`, `weights`, `delta` and `plan`, as of `MpcSystem`.
    Rate:
        period of the equivalent model, `rates.mpc_period_s` of a scenario.

    Args:
        formulation: Forms the program of each tick.
        faults: Faults of the scenario; only those of the MPC are used.
        settle_s: s, hover before reference time 0.
    """

    @checked
    def __init__(self, formulation: MpcFormulation, faults: Sequence[AnyFault], settle_s: Duration):
        super().__init__(formulation)
        self._faults = [fault for fault in faults if isinstance(fault, MpcFault)]
        self._settle_s = settle_s

    def extended(self, *terms: CustomTerm) -> "FaultyMpc":
        return FaultyMpc(self.formulation.extended(*terms), self._faults, self._settle_s)

    def active_fault(self, context: Context) -> AnyFault | None:
        """Returns the active fault of a Context; of starved ones, that with fewest iterations."""
        now = round(context.get_time() - self._settle_s, 9)
        return max(
            (fault for fault in self._faults if fault.is_active(now)),
            key=lambda fault: (SEVERITY.index(type(fault)), -getattr(fault, "iterations", 0)),
            default=None,
        )

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        if isinstance(self.active_fault(context), MpcMissed):
            tick = self.tick_inputs(context)
            program = self.formulation.form(tick)
            no_result = QpResult(np.zeros_like(program.g), MISSED)
            self._apply(context, discrete, tick, SolvedProgram(program, no_result))
        else:
            super()._update(context, discrete)

    def _solve(self, context: Context, program: MpcProgram) -> QpResult:
        match self.active_fault(context):
            case MpcStarved(iterations=iterations):
                name = self.formulation.config.solver
                return make_solver(name, iterations, is_refined=False).solve(program)
            case MpcInfeasible():
                ones = np.ones_like(program.lower)
                program = replace(program, lower=ones, upper=-ones)
            case MpcNonFinite():
                program = replace(program, g=np.full_like(program.g, np.nan))
        return super()._solve(context, program)


@checked
def make_mpc(
    formulation: MpcFormulation, faults: Sequence[AnyFault], settle_s: Duration
) -> MpcSystem:
    """Returns a scenario's MPC: a `FaultyMpc` if its faults include MPC faults."""
    if any(isinstance(fault, MpcFault) for fault in faults):
        return FaultyMpc(formulation, faults, settle_s)
    return MpcSystem(formulation)
