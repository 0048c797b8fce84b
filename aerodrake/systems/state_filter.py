"""The state filter as a system."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from aerodrake.model.state_filter import StateFilter, update
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
        `memory` (19 + 2 n + 6 steps): estimate, of the base at the time of its last
        sample, and accelerations from then to now; and what the outputs show.
        A sample that is not finite corrects nothing.
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
        since = np.tile(trim_acceleration, state_filter.steps)
        self._x_memory = self.DeclareDiscreteState(
            np.concatenate([-trim_acceleration, initial, since])
        )
        self._x_state = self.DeclareDiscreteState(initial)
        self.DeclareStateOutputPort("state", self._x_state)
        self._x_external = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("external_acceleration", self._x_external)
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, state: State) -> None:
        discrete = state.get_mutable_discrete_state()
        sample = self._sample.Eval(context)
        memory, now = update(
            self._filter,
            discrete.value(self._x_memory),
            self._acceleration.Eval(context),
            sample,
        )
        discrete.set_value(self._x_memory, memory)
        discrete.set_value(self._x_state, sample if self._passes else now[6:])
        discrete.set_value(self._x_external, now[:3] - self._reaction.Eval(context))
