"""Link that carries the setpoints from the coordinator to the station."""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.actuation.setpoint_messages import (
    LinkTiming,
    followed,
    latency,
    newest,
    sent,
)
from aerodrake.model.setpoint.integration import Segment
from aerodrake.support.arguments import Axes, checked
from aerodrake.systems.named_state import NamedState


class SetpointLinkState(NamedTuple):
    """State of the setpoint link.

    Attributes:
        messages: (1 + K, S) messages before the current one, as `sent` returns them; each is a
            `Segment` of S = 3 (3 + n) + 1 values.
        latency_s: s, latency of the current message.
        is_sending: True from the first message on, which arrives at once.
    """

    messages: np.ndarray
    latency_s: float
    is_sending: bool


class SetpointLink(LeafSystem):
    """Delivers setpoints late, out of order, or not at all.

    A message is the segment of a tick, as over LCM, but its time is not used, as if the two
    computers had no common clock: the polynomials begin when the message arrives. The station
    follows the last sent of all messages that have arrived.

    Ports:
        in `segment` (3 (3 + n) + 1): the coordinator's `Segment`, a message at each tick.
        in `draws` (2): uniform draws from [0, 1), new at each tick: for latency and loss.
        out `base_setpoint` (9): p_d, v_d, a_d in m, m/s, m/s^2, world frame.
        out `joint_setpoint` (3 n): q_d, q_d', q_d'' in rad, rad/s, rad/s^2.
    State:
        the fields of a `SetpointLinkState`, a group each.
    Rate:
        `timing.period`, with that of the coordinator's ticks, by a discrete update; between them
        the outputs are polynomials in time.

    Args:
        timing: Latency, loss and period.
        position: (3 + n,) p_B and q in trim.
    """

    @checked
    def __init__(self, timing: LinkTiming, position: Axes):
        super().__init__()
        self._timing = timing
        m = self._axes = len(position)
        trim = Segment(position, np.zeros(m), np.zeros(m), 0.0).to_vector()
        self._segment = self.DeclareVectorInputPort("segment", Segment.size(m))
        self._draws = self.DeclareVectorInputPort("draws", 2)
        messages = np.tile(trim, (1 + timing.pending, 1))
        self._last = NamedState(self, SetpointLinkState(messages, 0.0, False))
        tickets = {self.xd_ticket(), self._segment.ticket(), self.time_ticket()}
        self.DeclareVectorOutputPort("base_setpoint", 9, self._calc_base, tickets)
        self.DeclareVectorOutputPort("joint_setpoint", 3 * (m - 3), self._calc_joints, tickets)
        self.DeclarePeriodicDiscreteUpdateEvent(timing.period, 0.0, self._update)

    def _calc_base(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._setpoint(context, 0, 3))

    def _calc_joints(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._setpoint(context, 3, self._axes))

    def _setpoint(self, context: Context, first: int, end: int) -> np.ndarray:
        last, time = self._last.read(context), context.get_time()
        messages = sent(last.messages, self._segment.Eval(context), last.latency_s)
        message = newest(messages, time)
        return followed(message, time, self._timing.silence_s, first, end)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        last = self._last.read(context)
        if not last.is_sending:
            self._last.write(discrete, last._replace(is_sending=True))
            return
        messages = sent(last.messages, self._segment.Eval(context), last.latency_s)
        latency_s = latency(self._timing, self._draws.Eval(context))
        self._last.write(discrete, SetpointLinkState(messages, latency_s, True))
