"""The reference as it is followed."""

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

from aerodrake.model.reference.envelope import Envelope, accepted


class ReferenceGuard(LeafSystem):
    """Passes a reference on where it can be followed, and holds it where it cannot.

    Ports:
        in `horizon` (6 (N + 1)): p_Ed, p_Ed' in m and m/s, now and at each stage.
        out `horizon` (6 (N + 1)): the same, always finite and within the envelope. It feeds
            through, so that a tick sees what is asked for now.
        out `reference` (6): the same, now.
        out `reference_verdict` (1): a `ReferenceVerdict` on the last tick's.
    State:
        what was accepted at the last tick (6), what was asked for then (6), and the verdict.
    Rate:
        `period`, from time 0.

    Args:
        envelope: Where a reference may be.
        start: (3,) m, where the end-effector starts.
        stages: N.
        period: s.
    """

    def __init__(self, envelope: Envelope, start: np.ndarray, stages: int, period: float):
        super().__init__()
        self._envelope, self._period = envelope, period
        size = 6 * (stages + 1)
        self._asked = self.DeclareVectorInputPort("horizon", size)
        at_start = np.concatenate([start, np.zeros(3)])
        self._last = self.DeclareDiscreteState(at_start)
        self._last_asked = self.DeclareDiscreteState(at_start)
        self._verdict = self.DeclareDiscreteState(1)
        # Both outputs and the update need it: computed once a tick.
        self._accepted = self.DeclareCacheEntry(
            "accepted",
            ValueProducer(lambda: Value[object](None), self._calc_accepted),
            {self._asked.ticket(), self.xd_ticket()},
        )
        ticket = {self._accepted.ticket()}
        self.DeclareVectorOutputPort("horizon", size, self._calc_horizon, ticket)
        self.DeclareVectorOutputPort("reference", 6, self._calc_reference, ticket)
        self.DeclareStateOutputPort("reference_verdict", self._verdict)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc_accepted(self, context: Context, found: AbstractValue) -> None:
        rows = self._asked.Eval(context).reshape(-1, 6)
        state = context.get_discrete_state()
        last, asked = state.value(self._last), state.value(self._last_asked)
        found.set_value(accepted(self._envelope, rows, last, asked, self._period))

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._accepted.Eval(context)[0].ravel())

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._accepted.Eval(context)[0][0])

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        rows, verdict = self._accepted.Eval(context)
        discrete.set_value(self._last, rows[0])
        discrete.set_value(self._last_asked, self._asked.Eval(context)[:6])
        discrete.set_value(self._verdict, [verdict])
