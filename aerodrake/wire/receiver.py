"""From the coordinator's messages to its signals."""

from __future__ import annotations

from functools import partial

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem
from scipy.interpolate import CubicHermiteSpline

from aerodrake.model.mpc.tick import MISSED
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.residual.gate import GateCause
from aerodrake.model.sensing.sample_check import MAX_MAGNITUDE
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.wire.link import Link
from aerodrake.wire.message import Message, Phase

NUMBERED: dict[tuple[str, int], range] = {
    ("weights", 1): range(len(Mode)),
    ("status", 0): range(MISSED + 1),
    ("reference_verdict", 0): range(len(ReferenceVerdict)),
    ("learner_health", 0): range(len(GateCause)),
}
"""Parts, and places in them, that are one of so many things: others are told by nobody of ours."""

HORIZONS = {"horizon": ("reference", 6), "tool_axis_horizon": ("tool_axis_d", 3)}
"""Name and size of the port that interpolates each part with rows of value and derivative."""


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
        out `reference` (6), `tool_axis_d` (3) with an orientation task: the horizons of the last
            message, interpolated by cubic Hermite splines at the current time. Before the first
            message those of a hover in trim.
        out: the other parts of the link's messages as told last, but `segment`, `plan`,
            `tick_ms` and `output_time_s`; zero before the first.
    State:
        the parts of the last message; how many ticks ago the one that it answers was; and
        whether it answers the last one.
    Rate:
        `period`, that of the coordinator's ticks; and `poll_period`, after `poll_offset`.

    Args:
        link: This end of the wire. The parts it hears include `segment` (3 (3 + n) + 1),
            `plan` (P (3 + n)), `horizon` (6 K) and `output_time_s` (1), the time at which the
            coordinator evaluated its outputs.
        period: s.
        stages_s: (N + 1,) s, from the time of a horizon to each of its stages.
        vehicle: The vehicle, for its trim.
        poll_period, poll_offset: s, when messages are looked for.
    """

    def __init__(
        self,
        link: Link,
        period: float,
        stages_s: np.ndarray,
        vehicle: VehicleModel,
        poll_period: float,
        poll_offset: float,
    ):
        super().__init__()
        self._link, self._period, self._stages = link, period, stages_s
        sizes = link.hears.sizes
        self._axes = sizes["segment"] // 3
        still = np.zeros(3)
        trim = {
            "horizon": np.concatenate([vehicle.p_E, still]),
            "tool_axis_horizon": np.concatenate([vehicle.tool_axis, still]),
        }
        self._x = {
            name: self.DeclareDiscreteState(np.resize(trim.get(name, still), size))
            for name, size in sizes.items()
        }
        self._x_row = self.DeclareDiscreteState(1)
        self._x_answered = self.DeclareDiscreteState([1.0])
        state = {self.xd_ticket()}
        self.DeclareVectorOutputPort("u", self._axes, self._calc_u, state)
        self.DeclareVectorOutputPort("status", sizes["status"], self._calc_status, state)
        now = {self.xd_ticket(), self.time_ticket()}
        for name in sizes:
            if name in HORIZONS:
                self.DeclareVectorOutputPort(*HORIZONS[name], partial(self._interpolate, name), now)
            elif name not in ("segment", "plan", "tick_ms", "output_time_s", "status"):
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

    def _interpolate(self, horizon: str, context: Context, output: BasicVector) -> None:
        rows = self._value(context, self._x[horizon]).reshape(-1, 6)
        stages = self._stages[: len(rows)]
        spline = CubicHermiteSpline(stages, rows[:, :3], rows[:, 3:])
        since = context.get_time() - self._value(context, self._x["output_time_s"])[0]
        if since < stages[-1]:
            motion = np.concatenate([spline(since), spline(since, 1)])
        else:  # The horizon is over.
            motion = np.concatenate([rows[-1, :3], np.zeros(3)])
        output.SetFromVector(motion[: output.size()])

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
        asked = [message.parts[name] for name in ("segment", "plan", "horizon")]
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
