"""The MPC as a system."""

from __future__ import annotations

import time

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues

from aerodrake.model.mpc import MpcFormulation
from aerodrake.model.qp import CondensedQp, QpStatus
from aerodrake.systems.kinematic_controller import KinematicController


class MpcSystem(KinematicController):
    """Predictive kinematic control of the end-effector (paper, algorithm 1).

    Ports:
        those of every `KinematicController`; `status` is a `QpStatus`, and
        OSQP's iterations.
    State:
        beside theirs, `plan` (N (3 + n), the scaled inputs of the last plan).
    Rate:
        the equivalent model's period.

    A program that cannot be solved leaves the loop with the last plan, shifted
    by one tick; at its end it runs out into zero acceleration.

    Args:
        formulation: Cost and bounds.
    """

    def __init__(self, formulation: MpcFormulation):
        super().__init__(formulation.model, formulation.config.horizon)
        self._formulation = formulation
        self._qp = CondensedQp(formulation.A, formulation.config.max_iterations)
        self._inputs = 3 + formulation.model.joints
        # Where the shifted plan finds each stage's input in the last one, by ticks.
        ticks = formulation.stage_ticks
        stages = np.append(np.repeat(np.arange(len(ticks)), ticks), len(ticks))
        self._shift = stages[np.cumsum([1, *ticks[:-1]])]
        self._x_plan = self.DeclareDiscreteState(
            np.zeros(formulation.config.horizon * self._inputs)
        )

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tick = self.tick_inputs(context)
        last = context.get_discrete_state(self._x_plan).value()
        last = np.append(last, np.zeros(self._inputs)).reshape(-1, self._inputs)
        shifted = last[self._shift].ravel()

        start = time.perf_counter()
        program = self._formulation.form(tick)
        result = self._qp.solve(program.H, program.g, program.lower, program.upper)
        self.tick_ms.append(1e3 * (time.perf_counter() - start))

        plan = shifted if result.status is QpStatus.FAILED else result.z
        U = self._formulation.scale * plan
        prediction = self._formulation.predict(tick, program, U)
        discrete.set_value(self._x_plan, plan)
        self._command(discrete, U[: self._inputs], prediction, (result.status, result.iterations))
