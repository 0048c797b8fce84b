"""The state filter as a system."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from aerodrake.model.state_filter import Estimate, StateFilter
from aerodrake.model.vehicle_state import VehicleState


class StateFilterSystem(LeafSystem):
    """What everybody takes for the vehicle's state: samples, filtered and brought up to date.

    Ports:
        in `sample` (13 + 2 n): the last sample; its base is `filter.steps` late.
        in `acceleration` (6): of the flight controller, what the base is believed
            to have had since the last sample.
        in `reaction` (3): of the flight controller, m/s^2, part of `acceleration`.
        out `state` (13 + 2 n): the state now. If samples are exact, the last one.
        out `external_acceleration` (3): m/s^2 in the world, what accelerates the base
            beside thrust and gravity, the arm's reaction included.
    State:
        `estimate` (19 + 2 n) at the time of the base's last sample; `since`
        (steps, 6), accelerations from then to now; and what the outputs show.
        A sample that is not finite corrects nothing: the base goes on as modelled,
        and the arm stays where it was.
    Rate:
        `period`, by an *unrestricted* update: these run before the discrete
        updates of the same instant, so that a controller that ticks together
        with the sensors sees the new state and not one that is a period old.

    Args:
        state_filter: The equations.
        passes: Whether `state` is the sample as it is.
        joints: n.
        period: s.
        initial: (13 + 2 n,) the state before the first sample, at rest.
        trim_acceleration: (6,) as modelled then; what it says is not there.
    """

    def __init__(
        self,
        state_filter: StateFilter,
        passes: bool,
        joints: int,
        period: float,
        initial: np.ndarray,
        trim_acceleration: np.ndarray,
    ):
        super().__init__()
        self._filter = state_filter
        self._passes = passes
        self._sample = self.DeclareVectorInputPort("sample", VehicleState.size(joints))
        self._acceleration = self.DeclareVectorInputPort("acceleration", 6)
        self._reaction = self.DeclareVectorInputPort("reaction", 3)
        start = Estimate(
            VehicleState.from_vector(initial), -trim_acceleration[:3], -trim_acceleration[3:]
        )
        self._x_estimate = self.DeclareDiscreteState(start.to_vector())
        self._x_since = self.DeclareDiscreteState(np.tile(trim_acceleration, state_filter.steps))
        self._x_state = self.DeclareDiscreteState(initial)
        self.DeclareStateOutputPort("state", self._x_state)
        self._x_external = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("external_acceleration", self._x_external)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        x = self._sample.Eval(context)
        sample = VehicleState.from_vector(x)
        old = context.get_discrete_state
        last = VehicleState.from_vector(old(self._x_state).value())
        since = old(self._x_since).value().reshape(-1, 6)
        since = np.vstack([since, self._acceleration.Eval(context)])

        then = Estimate.from_vector(old(self._x_estimate).value())
        then = self._filter.follow(then, since[0])
        if np.isfinite(x).all():
            then = self._filter.correct(then, sample)
        else:
            sample = replace(last, qdot=0 * last.qdot)
        now = then
        for acceleration in since[1:]:
            now = self._filter.follow(now, acceleration)
        q = self._filter.joints(last.q, last.qdot, sample)
        found = replace(now.state, q=q, qdot=sample.qdot)
        for group, value in (
            (self._x_estimate, then.to_vector()),
            (self._x_since, since[1:].ravel()),
            (self._x_state, x if self._passes else found.to_vector()),
            (self._x_external, now.d - self._reaction.Eval(context)),
        ):
            state.get_mutable_discrete_state(group).SetFromVector(value)
