"""Setpoint integrator: setpoints of base and arm from accelerations."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.setpoint.integration import (
    Segment,
    SetpointLimits,
    admissible,
    evaluate,
    integrate,
    split_segment,
    start,
)
from aerodrake.model.supervision.safe_mode import SafeMode, SafeMotion, safe_acceleration
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.support.arguments import Axes, Period, checked
from aerodrake.systems.named_state import NamedState


class SetpointState(NamedTuple):
    """Discrete state of the setpoint integrator.

    Attributes:
        position: (3 + n,) m and rad, setpoints at the last tick.
        velocity: (3 + n,) m/s and rad/s.
        time_s: s, time of that tick.
        mode: The `SafeMode` since that tick.
        position_offset: (3,) m, sum of the resets up to that tick.
        has_started: False before the first tick.
    """

    position: np.ndarray
    velocity: np.ndarray
    time_s: float
    mode: float
    position_offset: np.ndarray
    has_started: bool


class SetpointIntegrator(LeafSystem):
    """Integrates u twice, exactly and within limits; in safe modes, its own accelerations instead.

    The setpoints start at the measured state, within their limits. If a reset moves the estimated
    position, they move with it, so that the vehicle does not.

    Ports:
        in `u` (3 + n): accelerations in m/s^2 and rad/s^2, constant between ticks.
        in `mode` (1): a `SafeMode`, sampled at each tick.
        in `followed` (3 (3 + n) + 1): the `Segment` that the vehicle follows, if another
            integrator decides it; unconnected otherwise.
        in `state` (13 + 2 n): measured `VehicleState`, used before the first tick; unconnected, the
            setpoints start at rest at `position`.
        in `position_offset` (3): m, sum of the resets of the estimated position; those of
            `followed` are in it already, and the port may be unconnected.
        out `base_setpoint` (9): p_d, v_d, a_d in m, m/s, m/s^2, world frame.
        out `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
        out `segment` (3 (3 + n) + 1): the `Segment` until the next tick.
    State:
        groups of a `SetpointState`.
    Rate:
        `period`; between ticks the outputs are exact polynomials in time.

    Args:
        limits: Limits of the setpoints, (3 + n).
        motion: Motion in safe modes.
        position: (3 + n,) p_B and q in trim.
        period: s.
    """

    @checked
    def __init__(self, limits: SetpointLimits, motion: SafeMotion, position: Axes, period: Period):
        super().__init__()
        self._limits, self._motion = limits, motion
        self._period = period
        m = self._axes = len(position)
        self._u = self.DeclareVectorInputPort("u", m)
        self._mode = self.DeclareVectorInputPort("mode", 1)
        self._followed = self.DeclareVectorInputPort("followed", Segment.size(m))
        self._state = self.DeclareVectorInputPort("state", VehicleState.size(m - 3))
        self._offset = self.DeclareVectorInputPort("position_offset", 3)
        mode = float(SafeMode.NOMINAL)
        initial = SetpointState(position, np.zeros(m), 0.0, mode, np.zeros(3), False)
        self._x = NamedState(self, initial)
        # Independent of time, so that between ticks only polynomials are evaluated.
        ports = self._u, self._followed, self._state, self._offset
        tickets = {self.xd_ticket(), *(port.ticket() for port in ports)}
        self._segment = self.DeclareVectorOutputPort(
            "segment", Segment.size(m), self._calc_segment, tickets
        )
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc_base)
        self.DeclareVectorOutputPort("joint_setpoint", 3 * (m - 3), self._calc_joints)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_segment(self, context: Context, output: BasicVector) -> None:
        last = self._x.read(context)
        p, v = last.position, last.velocity
        if last.has_started:
            p[:3] += self._position_offset(context) - last.position_offset
        elif self._followed.HasValue(context):
            output.set_value(self._followed.Eval(context))
            return
        elif self._state.HasValue(context):
            p, v = start(self._limits, self._state.Eval(context))
        u = safe_acceleration(self._motion, last.mode, p, v, self._u.Eval(context))
        u = admissible(self._limits, p, v, u, self._period)
        output.set_value(Segment(p, v, u, last.time_s).to_vector())

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.set_value(evaluate(self._segment.Eval(context), context.get_time(), 0, 3))

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        segment, time = self._segment.Eval(context), context.get_time()
        output.set_value(evaluate(segment, time, 3, self._axes))

    def _position_offset(self, context: Context) -> np.ndarray:
        return self._offset.Eval(context) if self._offset.HasValue(context) else np.zeros(3)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        port = self._followed if self._followed.HasValue(context) else self._segment
        p, v, u, tick_s = split_segment(port.Eval(context))
        time = context.get_time()
        p, v = integrate(p, v, u, time - tick_s)
        mode, offset = self._mode.Eval(context)[0], self._position_offset(context)
        self._x.write(discrete, SetpointState(p, v, time, mode, offset, True))
