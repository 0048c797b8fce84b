"""Closed-loop inverse kinematics as a system, in place of the MPC."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from aerodrake.model.mpc.clik import ClikCommand, InverseKinematics
from aerodrake.model.mpc.tick import MpcInputs
from aerodrake.model.qp.result import QpStatus
from aerodrake.support.arguments import checked
from aerodrake.systems.kinematic_controller import KinematicController


class ClikSystem(KinematicController):
    """Weighted closed-loop inverse kinematics (CLIK), a baseline for the MPC.

    Ports:
        those of `KinematicController`, of which
        out `prediction` (3 (N + 1)): m, p_E now and at each stage at the commanded velocity.
        out `status` (3): `TickStatus`: UNCONSTRAINED, SOLVED if u was clipped, or NON_FINITE if
            it was NaN or infinite; 0 iterations; and ticks since the last finite u.
        out `plan` (2 (3 + n)): m/s^2 and rad/s^2, u at the last tick, which is also that of the
            next one.
    State:
        `u`, `prediction`, `status`, `weights` and `delta`, of the last tick.
    Rate:
        period of the equivalent model, `rates.mpc_period_s` of a scenario.

    If u is NaN or infinite, zero acceleration is commanded.

    Args:
        inverse: The equations.
    """

    @checked
    def __init__(self, inverse: InverseKinematics):
        super().__init__(inverse.model, inverse.mpc.horizon)
        self._inverse = inverse
        self.DeclareVectorOutputPort(
            "plan", 2 * (3 + inverse.model.joints), self._calc_plan, {self.xd_ticket()}
        )

    def _calc_plan(self, context: Context, output: BasicVector) -> None:
        output.set_value(np.tile(self._last.read(context).u, 2))

    def solve_tick(self, context: Context, tick: MpcInputs) -> ClikCommand:
        return self._inverse.command(tick)

    def _apply(
        self, context: Context, discrete: DiscreteValues, tick: MpcInputs, solution: ClikCommand
    ) -> None:
        u, status = solution.u, QpStatus.UNCONSTRAINED
        if solution.is_clipped:
            status = QpStatus.SOLVED
        if not np.isfinite(u).all():
            u, status = np.zeros_like(u), QpStatus.NON_FINITE
        prediction = self._inverse.predict(tick, solution.velocity)
        self._set_outputs(context, discrete, u, prediction, status, 0)
