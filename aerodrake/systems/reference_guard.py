"""The reference guard as a system."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    LeafSystem,
    ValueProducer,
)

from aerodrake.model.reference.envelope import (
    Envelope,
    GuardState,
    ReferenceVerdict,
    guard_reference,
)
from aerodrake.support.arguments import Count, Period, Vector3, checked
from aerodrake.systems.named_state import NamedState


class ReferenceGuard(LeafSystem):
    """Passes the reference on within its envelope; outside, rests at the last accepted position.

    Ports:
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' in m and m/s, now and at each stage.
        out `horizon` (6 (N + 1)): p_Ed, p_Ed' in m and m/s, now and at each stage, always finite
            and within the envelope. Direct feedthrough, so that a tick samples the present
            request. A refused reference rests at the position that was passed on at the last
            tick.
        out `reference` (6): p_Ed, p_Ed' in m and m/s, now, always finite and within the envelope.
        out `reference_verdict` (1): a `ReferenceVerdict` on the reference at the last tick.
    State:
        the fields of `GuardState`, a group each.
    Rate:
        `period`, from time 0.

    Args:
        envelope: Limits of the reference.
        start: (3,) m, initial position of the end-effector.
        stages: N.
        period: s.
    """

    @checked
    def __init__(self, envelope: Envelope, start: Vector3, stages: Count, period: Period):
        super().__init__()
        self._envelope, self._period = envelope, period
        size = 6 * (stages + 1)
        self._requested = self.DeclareVectorInputPort("horizon", size)
        at_rest = np.concatenate([start, np.zeros(3)])
        self._state = NamedState(self, GuardState(at_rest, at_rest, int(ReferenceVerdict.OK)))
        # Computed once per tick for both outputs and the update.
        self._guarded = self.DeclareCacheEntry(
            "guarded",
            ValueProducer(lambda: Value[object](None), self._calc_guarded),
            {self._requested.ticket(), self.xd_ticket()},
        )
        ticket = {self._guarded.ticket()}
        self.DeclareVectorOutputPort("horizon", size, self._calc_horizon, ticket)
        self.DeclareVectorOutputPort("reference", 6, self._calc_reference, ticket)
        self.DeclareStateOutputPort("reference_verdict", self._state.groups["verdict"])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_guarded(self, context: Context, guarded: AbstractValue) -> None:
        rows, state = self._requested.Eval(context).reshape(-1, 6), self._state.read(context)
        guarded.set_value(guard_reference(self._envelope, rows, state, self._period))

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._guarded.Eval(context)[0].ravel())

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._guarded.Eval(context)[0][0])

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        accepted, verdict = self._guarded.Eval(context)
        requested = self._requested.Eval(context)[:6]
        self._state.write(discrete, GuardState(accepted[0], requested, verdict))
