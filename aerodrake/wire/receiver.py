"""System that outputs the signals of the coordinator's messages."""

from collections import namedtuple
from functools import partial

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem
from scipy.interpolate import CubicHermiteSpline

from aerodrake.model.mpc.tick import MISSED, TickStatus
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.reference.envelope import ReferenceVerdict
from aerodrake.model.residual.delta_blend import DeltaSource
from aerodrake.model.residual.layer_gate import GateCause
from aerodrake.model.sensing.sample_check import MAX_MAGNITUDE
from aerodrake.model.setpoint.integration import Segment, split_segment
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.support.arguments import Duration, Period, Vector, checked
from aerodrake.systems.named_state import NamedState
from aerodrake.wire.link import Link
from aerodrake.wire.message import Message, Phase

ENUMERATIONS: dict[tuple[str, int], range] = {
    ("weights", 1): range(len(Mode)),
    ("status", 0): range(MISSED + 1),
    ("reference_verdict", 0): range(len(ReferenceVerdict)),
    ("learner_health", 0): range(len(GateCause)),
    ("delta_source", 0): range(len(DeltaSource)),
}
"""Valid values of the enumerations in messages, by signal and index."""

HORIZONS = {"horizon": ("reference", 6), "tool_axis_horizon": ("tool_axis_d", 3)}
"""Name and size of the port that interpolates each signal with rows of value and derivative."""

REQUESTED = "requested_reference"
"""Name of the signal and port of the reference before faults and guard."""

INTERNAL = ("segment", "plan", "tick_ms", "output_time_s")
"""Signals of messages that are no output ports."""


class WireReceiver(LeafSystem):
    """Outputs the signals of the coordinator's last message.

    A message is the reply to a tick. It is accepted until the next tick; if none arrives, the
    tick was missed. Until the reply arrives, `u` follows the plan of the last accepted message,
    as the MPC follows the last plan that it could solve. The latency of a reply therefore hardly
    affects the flight.

    Ports:
        out `u` (3 + n): m/s^2 and rad/s^2, current accelerations of the setpoints; zero after
            the end of the plan.
        out `status` (3): `TickStatus` as received; before the reply to the last tick, MISSED,
            0 iterations, and the number of ticks since the last program was solved.
        out `reference` (6): p_Ed, p_Ed' in m and m/s, from the horizon of the last message,
            interpolated by cubic Hermite splines at the current time; before the first message
            that of a hover in trim.
        out `requested_reference` (6): p_Ed, p_Ed' in m and m/s, before faults and guard; while it
            is not followed, extrapolated at its velocity.
        out `tool_axis_d` (3): desired direction of the tool's axis, interpolated likewise from
            its horizon; only with an orientation task.
        out `prediction` (3 (N + 1)): m, p_E predicted by the MPC in the last message.
        out `weights` (5): `AllocatedWeights` in the last message.
        out `delta` (3): residual of the equivalent model in the last message.
        out `prediction_error` (3): m/s, error of the residual estimator in the last message.
        out `nominal_prediction_error` (3): m/s, that without Delta, in the last message.
        out `reference_verdict` (1): `ReferenceVerdict` in the last message.
        out `learner_health` (2): `GateCause` and s since then, in the last message.
        out `delta_source` (1): `DeltaSource` in the last message.
        out `stable_learning_rate` (1): bound of the learning rate in the last message.
        Those of the last accepted message are zero before the first.
    State:
        the signals of the last accepted message, one group each; `ticks_since_reply`, the number
        of ticks since the one it replies to; `has_reply`, 1 if that is the last tick.
    Rate:
        `period`, that of the coordinator's ticks; messages are polled at each `poll_period`,
        after `poll_offset`.

    Args:
        link: Station's end of the link. Its incoming signals include `segment` (3 (3 + n) + 1),
            `plan` (P (3 + n)), `horizon` (6 K) and `output_time_s` (1), the time at which the
            coordinator evaluated its outputs.
        period: s.
        stages_s: (N + 1,) s, from the time of a horizon to each of its stages.
        vehicle: The vehicle, for its trim.
        poll_period, poll_offset: s.
    """

    @checked
    def __init__(
        self,
        link: Link,
        period: Period,
        stages_s: Vector,
        vehicle: VehicleModel,
        poll_period: Period,
        poll_offset: Duration,
    ):
        super().__init__()
        self._link, self._period, self._stages = link, period, stages_s
        sizes = link.incoming.sizes
        self._axes = Segment.axes(sizes["segment"])
        zeros = np.zeros(3)
        trim = {
            "horizon": np.concatenate([vehicle.p_E, zeros]),
            REQUESTED: np.concatenate([vehicle.p_E, zeros]),
            "tool_axis_horizon": np.concatenate([vehicle.tool_axis, zeros]),
        }
        initial = {name: np.resize(trim.get(name, zeros), size) for name, size in sizes.items()}
        state_type = namedtuple("WireReceiverState", [*sizes, "ticks_since_reply", "has_reply"])
        self._state = NamedState(self, state_type(**initial, ticks_since_reply=0, has_reply=True))
        state, now = {self.xd_ticket()}, {self.xd_ticket(), self.time_ticket()}
        self.DeclareVectorOutputPort("u", self._axes, self._calc_u, state)
        self.DeclareVectorOutputPort("status", sizes["status"], self._calc_status, state)
        for name in sizes:
            if name in HORIZONS:
                self.DeclareVectorOutputPort(*HORIZONS[name], partial(self._interpolate, name), now)
            elif name == REQUESTED:
                self.DeclareVectorOutputPort(name, 6, self._calc_requested, now)
            elif name not in (*INTERNAL, "status"):
                self.DeclareStateOutputPort(name, self._state.groups[name])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._tick)
        self.DeclarePeriodicDiscreteUpdateEvent(poll_period, poll_offset, self._poll)

    def _calc_u(self, context: Context, output: BasicVector) -> None:
        state = self._state.read(context)
        u = split_segment(state.segment).acceleration
        if state.ticks_since_reply:  # The segment is over.
            plan = state.plan.reshape(-1, self._axes)
            row = state.ticks_since_reply
            u = plan[row] if row < len(plan) else np.zeros(self._axes)
        output.set_value(u)

    def _calc_status(self, context: Context, output: BasicVector) -> None:
        state = self._state.read(context)
        status = TickStatus(*state.status)
        if not state.has_reply:
            ticks = status.ticks_since_solved + state.ticks_since_reply
            status = TickStatus(MISSED, 0.0, ticks)
        output.set_value(status)

    def _interpolate(self, horizon: str, context: Context, output: BasicVector) -> None:
        state = self._state.read(context)
        rows = getattr(state, horizon).reshape(-1, 6)
        stages = self._stages[: len(rows)]
        spline = CubicHermiteSpline(stages, rows[:, :3], rows[:, 3:])
        since = context.get_time() - state.output_time_s[0]
        if since < stages[-1]:
            motion = np.concatenate([spline(since), spline(since, 1)])
        else:  # The horizon is over.
            motion = np.concatenate([rows[-1, :3], np.zeros(3)])
        output.SetFromVector(motion[: output.size()])

    def _calc_requested(self, context: Context, output: BasicVector) -> None:
        state = self._state.read(context)
        p, v = np.split(getattr(state, REQUESTED), 2)
        if np.array_equal([*p, *v], state.horizon[:6]):
            self._interpolate("horizon", context, output)
        else:
            since = context.get_time() - state.output_time_s[0]
            output.SetFromVector(np.concatenate([p + v * since, v]))

    def _tick(self, context: Context, discrete: DiscreteValues) -> None:
        state = self._state.read(context)
        ticks = state.ticks_since_reply + 1
        self._state.write(discrete, state._replace(ticks_since_reply=ticks, has_reply=False))

    def _poll(self, context: Context, discrete: DiscreteValues) -> None:
        messages = self._link.receive()
        if not messages or self._state.read(context).has_reply:
            return
        last_tick = np.floor(context.get_time() / self._period + 1e-6) * self._period
        of_tick = [m for m in messages if self._is_reply_to(m, last_tick)]
        replies = [m for m in of_tick if self._has_valid_signals(m)]
        if len(replies) < len(of_tick):
            self._link.reject("replies with absurd values are ignored")
        if not replies:
            return
        reply = replies[0]
        state = self._state.read(context)._replace(**reply.signals)
        self._state.write(discrete, state._replace(ticks_since_reply=0, has_reply=True))
        if np.isfinite(reply.signals["tick_ms"][0]):
            self._link.tick_ms.append(reply.signals["tick_ms"][0])

    def _is_reply_to(self, message: Message, tick: float) -> bool:
        """Returns True if a message replies to the tick at that time in s."""
        return message.phase is Phase.FLYING and abs(message.time - tick) < self._period / 2

    def _has_valid_signals(self, message: Message) -> bool:
        """Returns True if the signals of a message are bounded, and its enumerations valid."""
        followed = [message.signals[name] for name in ("segment", "plan", "horizon")]
        return all((np.abs(values) < MAX_MAGNITUDE).all() for values in followed) and all(
            message.signals[name][index] in values
            for (name, index), values in ENUMERATIONS.items()
            if name in message.signals
        )
