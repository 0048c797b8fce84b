"""From the MPC's accelerations to the setpoints of base and arm."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.setpoint import SetpointLimits, advanced, evaluate, segment


class SetpointIntegrator(LeafSystem):
    """Exact double integration of u, within limits.

    Ports:
        in `u` (3 + n): accelerations, m/s^2 and rad/s^2, held between ticks.
        out `base_setpoint` (9): p_d, v_d, a_d.
        out `joint_setpoint` (3 n): q_d, q_d', q_d''.
        out `segment` (3 (3 + n) + 1): the polynomials that they follow until the next
            tick: positions and velocities at the last one, accelerations, and its time.
    State:
        positions and velocities (3 + n each) of the setpoints at the last tick,
        and its time.
    Rate:
        `period`; between ticks the outputs are the exact polynomials in time.

    Args:
        limits: Of setpoints, (3 + n).
        position: (3 + n,) setpoints at the start: p_B and q in trim.
        period: s.
    """

    def __init__(self, limits: SetpointLimits, position: np.ndarray, period: float):
        super().__init__()
        self._limits = limits
        self._period = period
        m = self._axes = len(position)
        self._u = self.DeclareVectorInputPort("u", m)
        self.DeclareDiscreteState(np.concatenate([position, np.zeros(m + 1)]))
        # Does not change with time: between ticks only polynomials are evaluated.
        self._segment = self.DeclareVectorOutputPort(
            "segment", 3 * m + 1, self._calc_segment, {self.xd_ticket(), self._u.ticket()}
        )
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc_base)
        self.DeclareVectorOutputPort("joint_setpoint", 3 * (m - 3), self._calc_joints)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_segment(self, context: Context, output: BasicVector) -> None:
        x = context.get_discrete_state_vector().value()
        output.set_value(segment(self._limits, x, self._u.Eval(context), self._period))

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.set_value(evaluate(self._segment.Eval(context), context.get_time(), 0, 3))

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        segment, time = self._segment.Eval(context), context.get_time()
        output.set_value(evaluate(segment, time, 3, self._axes))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        discrete.set_value(advanced(self._segment.Eval(context), context.get_time()))
