"""From the coordinator's messages to its signals."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.mpc.tick import MISSED
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.residual.gate import GateCause
from aerodrake.model.sensing.sample_check import MAX_MAGNITUDE
from aerodrake.wire.link import Link
from aerodrake.wire.message import Message, Phase

NUMBERED: dict[tuple[str, int], range] = {
    ("weights", 1): range(len(Mode)),
    ("status", 0): range(MISSED + 1),
    ("reference_verdict", 0): range(len(ReferenceVerdict)),
    ("learner_health", 0): range(len(GateCause)),
}
"""Parts, and places in them, that are one of so many things: others are told by nobody of ours."""


class WireReceiver(LeafSystem):
    """What the coordinator told last, and what it asks for while it says nothing.

    A message answers a tick, in the time until the next one, or it is too late: then that
    tick was missed. Until the answer is there, and where none comes, its plan is followed, as
    the MPC itself follows the last one that it could solve. So the time that an answer takes
    costs next to nothing.

    Ports:
        out `u` (3 + n): m/s^2 and rad/s^2, accelerations of the setpoints, as told for now;
            zero where the plan has come to its end.
        out `status` (3): as told; while the last tick is not answered, MISSED, 0 iterations,
            and how many ticks ago the last answer was.
        out: the other parts of the link's messages as told last, but `segment`, `plan` and
            `tick_ms`; zero before the first.
    State:
        the parts of the last message; how many ticks ago the one that it answers was; and
        whether it answers the last one.
    Rate:
        `period`, that of the coordinator's ticks; and `poll_period`, after `poll_offset`.

    Args:
        link: This end of the wire. The parts it hears include `segment` (3 (3 + n) + 1) and
            `plan` (P (3 + n)).
        period: s.
        poll_period, poll_offset: s, when messages are looked for.
    """

    def __init__(self, link: Link, period: float, poll_period: float, poll_offset: float):
        super().__init__()
        self._link, self._period = link, period
        sizes = link.hears.sizes
        self._axes = sizes["segment"] // 3
        self._x = {name: self.DeclareDiscreteState(size) for name, size in sizes.items()}
        self._x_row = self.DeclareDiscreteState(1)
        self._x_answered = self.DeclareDiscreteState([1.0])
        state = {self.xd_ticket()}
        self.DeclareVectorOutputPort("u", self._axes, self._calc_u, state)
        self.DeclareVectorOutputPort("status", sizes["status"], self._calc_status, state)
        for name in sizes.keys() - {"segment", "plan", "tick_ms", "status"}:
            self.DeclareStateOutputPort(name, self._x[name])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._tick)
        self.DeclarePeriodicDiscreteUpdateEvent(poll_period, poll_offset, self._poll)

    def _calc_u(self, context: Context, output: BasicVector) -> None:
        row, m = int(self._value(context, self._x_row)[0]), self._axes
        u = self._value(context, self._x["segment"])[2 * m : 3 * m]
        if row:  # Its segment is over.
            plan = self._value(context, self._x["plan"]).reshape(-1, m)
            u = plan[row] if row < len(plan) else np.zeros(m)
        output.set_value(u)

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        status = self._value(context, self._x["status"])
        if not self._value(context, self._x_answered)[0]:
            status = [MISSED, 0.0, status[2] + self._value(context, self._x_row)[0]]
        output.set_value(status)

    def _tick(self, context: Context, discrete: DiscreteValues) -> None:
        discrete.set_value(self._x_row, self._value(context, self._x_row) + 1)
        discrete.set_value(self._x_answered, [0.0])

    def _poll(self, context: Context, discrete: DiscreteValues) -> None:
        last_tick = np.floor(context.get_time() / self._period + 1e-6) * self._period
        for message in self._link.hear():
            is_answered = discrete.value(self._x_answered)[0]
            if not is_answered and self._answers(message, last_tick):
                for name, numbers in message.parts.items():
                    discrete.set_value(self._x[name], numbers)
                discrete.set_value(self._x_row, [0.0])
                discrete.set_value(self._x_answered, [1.0])
                if np.isfinite(message.parts["tick_ms"][0]):
                    self._link.tick_ms.append(message.parts["tick_ms"][0])

    def _answers(self, message: Message, tick: float) -> bool:
        """Whether it is an answer to the tick of that time, and one to be followed."""
        asked = message.parts["segment"], message.parts["plan"]
        return (
            message.phase is Phase.FLYING
            and abs(message.time - tick) < self._period / 2
            and all((np.abs(numbers) < MAX_MAGNITUDE).all() for numbers in asked)
            and all(
                message.parts[name][place] in NUMBERED[name, place]
                for name, place in NUMBERED
                if name in message.parts
            )
        )

    @staticmethod
    def _value(context: Context, index: int) -> np.ndarray:
        return context.get_discrete_state(index).value()
