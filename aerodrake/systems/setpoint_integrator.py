"""From the MPC's accelerations to the setpoints of base and arm."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.setpoint.integration import SetpointLimits, advanced, evaluate, segment
from aerodrake.model.supervision.safe_mode import SafeMotion, safe_acceleration


class SetpointIntegrator(LeafSystem):
    """Exact double integration of u, within limits; in a safe mode, of what that asks for.

    Ports:
        in `u` (3 + n): accelerations, m/s^2 and rad/s^2, held between ticks.
        in `mode` (1): a `SafeMode`, heeded from tick to tick.
        in `followed` (3 (3 + n) + 1): the segment that setpoints are on, where somebody else
            has the last word on it; unconnected where it is this system's own.
        out `base_setpoint` (9): p_d, v_d, a_d.
        out `joint_setpoint` (3 n): q_d, q_d', q_d''.
        out `segment` (3 (3 + n) + 1): the polynomials that they follow until the next
            tick: positions and velocities at the last one, accelerations, and its time.
    State:
        positions and velocities (3 + n each) of the setpoints at the last tick,
        and its time; the mode since then.
    Rate:
        `period`; between ticks the outputs are the exact polynomials in time.

    Args:
        limits: Of setpoints, (3 + n).
        motion: Of setpoints in safe modes.
        position: (3 + n,) setpoints at the start: p_B and q in trim.
        period: s.
    """

    def __init__(
        self, limits: SetpointLimits, motion: SafeMotion, position: np.ndarray, period: float
    ):
        super().__init__()
        self._limits, self._motion = limits, motion
        self._period = period
        m = self._axes = len(position)
        self._u = self.DeclareVectorInputPort("u", m)
        self._mode = self.DeclareVectorInputPort("mode", 1)
        self._followed = self.DeclareVectorInputPort("followed", 3 * m + 1)
        self._x = self.DeclareDiscreteState(np.concatenate([position, np.zeros(m + 1)]))
        self._x_mode = self.DeclareDiscreteState(1)
        # Does not change with time: between ticks only polynomials are evaluated.
        self._segment = self.DeclareVectorOutputPort(
            "segment", 3 * m + 1, self._calc_segment, {self.xd_ticket(), self._u.ticket()}
        )
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc_base)
        self.DeclareVectorOutputPort("joint_setpoint", 3 * (m - 3), self._calc_joints)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_segment(self, context: Context, output: BasicVector) -> None:
        state = context.get_discrete_state()
        x, mode = state.value(self._x), state.value(self._x_mode)[0]
        u = safe_acceleration(self._motion, mode, x, self._u.Eval(context))
        output.set_value(segment(self._limits, x, u, self._period))

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.set_value(evaluate(self._segment.Eval(context), context.get_time(), 0, 3))

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        segment, time = self._segment.Eval(context), context.get_time()
        output.set_value(evaluate(segment, time, 3, self._axes))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        followed = self._followed if self._followed.HasValue(context) else self._segment
        x = advanced(followed.Eval(context), context.get_time())
        discrete.set_value(self._x, x)
        discrete.set_value(self._x_mode, self._mode.Eval(context))
