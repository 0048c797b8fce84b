"""Closed-loop inverse kinematics as a system, in the MPC's place."""

from __future__ import annotations

import time

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from aerodrake.model.mpc.clik import InverseKinematics
from aerodrake.model.qp.condensed_qp import QpStatus
from aerodrake.systems.kinematic_controller import KinematicController


class ClikSystem(KinematicController):
    """Weighted closed-loop inverse kinematics: the method the paper argues against.

    Ports:
        those of every `KinematicController`. `prediction` goes on at the wanted
        velocity; `status` is UNCONSTRAINED, SOLVED where a bound cut u, or
        NON_FINITE where an input was not, and 0 iterations. `plan` (2 (3 + n)) is u, held
        for one tick more.
    State, rate:
        theirs.

    A tick whose inputs are not finite commands zero acceleration.

    Args:
        inverse: The equations.
    """

    def __init__(self, inverse: InverseKinematics):
        super().__init__(inverse.model, inverse.mpc.horizon)
        self._inverse = inverse
        self.DeclareVectorOutputPort(
            "plan", 2 * (3 + inverse.model.joints), self._calc_plan, {self.xd_ticket()}
        )

    def _calc_plan(self, context: Context, output: BasicVector) -> None:
        output.set_value(np.tile(context.get_discrete_state(self._x_u).value(), 2))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        tick = self.tick_inputs(context)
        start = time.perf_counter()
        command = self._inverse.command(tick)
        self.tick_ms.append(1e3 * (time.perf_counter() - start))

        u, status = command.u, QpStatus.SOLVED if command.is_bounded else QpStatus.UNCONSTRAINED
        if not np.isfinite(u).all():
            u, status = np.zeros_like(u), QpStatus.NON_FINITE
        prediction = self._inverse.predict(tick, command.velocity)
        self._command(context, discrete, u, prediction, status, 0)
