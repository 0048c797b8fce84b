"""From the MPC's accelerations to the setpoints of base and arm."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from aerodrake.model.setpoint import SetpointLimits, integrate


class SetpointIntegrator(LeafSystem):
    """Exact double integration of u, within limits.

    Ports:
        in `u` (3 + n): accelerations, m/s^2 and rad/s^2, held between ticks.
        out `base_setpoint` (9): p_d, v_d, a_d.
        out `joint_setpoint` (3 n): q_d, q_d', q_d''.
    State:
        `position` and `velocity` (3 + n) of the setpoints, and time, at the
        last tick.
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
        m = len(position)
        self._u = self.DeclareVectorInputPort("u", m)
        self._x_position = self.DeclareDiscreteState(position)
        self._x_velocity = self.DeclareDiscreteState(np.zeros(m))
        self._x_time = self.DeclareDiscreteState(np.zeros(1))
        # One evaluation serves both ports and the update.
        self._now = self.DeclareCacheEntry(
            "setpoint", ValueProducer(lambda: Value(object()), self._calc_setpoint)
        )
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc_base)
        self.DeclareVectorOutputPort("joint_setpoint", 3 * (m - 3), self._calc_joints)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_setpoint(self, context: Context, setpoint: AbstractValue) -> None:
        """(3, 3 + n), position, velocity and acceleration."""
        p = context.get_discrete_state(self._x_position).value()
        v = context.get_discrete_state(self._x_velocity).value()
        since = context.get_time() - context.get_discrete_state(self._x_time).value()[0]
        u = self._limits.admissible(p, v, self._u.Eval(context), self._period)
        setpoint.set_value(np.stack([*integrate(p, v, u, since), u]))

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._now.Eval(context)[:, :3].ravel())

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._now.Eval(context)[:, 3:].ravel())

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        p, v, _ = self._now.Eval(context)
        discrete.set_value(self._x_position, p)
        discrete.set_value(self._x_velocity, v)
        discrete.set_value(self._x_time, [context.get_time()])
