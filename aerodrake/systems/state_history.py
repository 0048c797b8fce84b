"""Past states, for samples whose latency is drawn."""

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiscreteValues,
    EventStatus,
    LeafSystem,
    State,
)

from aerodrake.model.sensing.latency import DRAWS, Delivery
from aerodrake.model.sensing.sample import ACCELEROMETER, GROUPS, TOOL, moved_back, replace_group
from aerodrake.support.arguments import StateVector, checked


class StateHistory(LeafSystem):
    """Outputs past states: for each sensor that of its delay plus latency ago.

    Before the simulation starts, the base is assumed to have moved at its initial velocity.

    Ports:
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        in `encoder_state` (13 + 2 n): true state with the angles and rates that encoders measure.
        in `draws` (10): uniform, new for each sample: latencies of the sensors, then losses.
        out `sampled_state` (13 + 2 n): position, attitude and joints, each of its own time.
        out `accelerometer_states` (26 + 4 n): true states at both ends of its period.
        out `tool_state` (13 + 2 n): true state for the tool sensor.
    State:
        `states`: true and encoder state of the last `steps` plant steps, the newest first.
    Rate:
        `delivery.step`, by a discrete update. And when a Simulator is initialised at the start, by
        an unrestricted update.

    Args:
        delivery: Delays and latencies.
        period_steps: Period of the accelerometer in plant steps; 0 without.
        initial: (13 + 2 n,) the state before the simulation starts.
    """

    @checked
    def __init__(self, delivery: Delivery, period_steps: int, initial: StateVector):
        super().__init__()
        self._delivery, self._period_steps = delivery, period_steps
        self._steps, self._size = max(1, delivery.longest + period_steps), len(initial)
        self._true_state = self.DeclareVectorInputPort("true_state", self._size)
        self._encoder_state = self.DeclareVectorInputPort("encoder_state", self._size)
        self._draws = self.DeclareVectorInputPort("draws", DRAWS)
        self._states = self.DeclareDiscreteState(np.tile(initial, 2 * self._steps))
        self._is_started = self.DeclareDiscreteState(1)
        ports = (
            ("sampled_state", self._size, self._calc_sampled),
            ("accelerometer_states", 2 * self._size, self._calc_accelerometer),
            ("tool_state", self._size, self._calc_tool),
        )
        for name, size, calc in ports:
            self.DeclareVectorOutputPort(name, size, calc)
        self.DeclareInitializationUnrestrictedUpdateEvent(self._start)
        self.DeclarePeriodicDiscreteUpdateEvent(delivery.step, 0.0, self._update)

    def _start(self, context: Context, state: State) -> EventStatus:
        if context.get_discrete_state(self._is_started)[0]:  # A Context from within a flight.
            return EventStatus.DidNothing()
        true, encoder = self._true_state.Eval(context), self._encoder_state.Eval(context)
        step = self._delivery.step
        rows = [moved_back(x, k * step) for k in range(1, self._steps + 1) for x in (true, encoder)]
        discrete = state.get_mutable_discrete_state()
        discrete.set_value(self._states, np.concatenate(rows))
        discrete.set_value(self._is_started, [1.0])
        return EventStatus.Succeeded()

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        states, row = discrete.get_mutable_value(self._states), 2 * self._size
        states[row:] = states[:-row]
        states[: self._size] = self._true_state.Eval(context)
        states[self._size : row] = self._encoder_state.Eval(context)

    def _state(self, context: Context, steps: int, is_encoder: bool = False) -> np.ndarray:
        """Returns the true state, or that of the encoders, of some plant steps before."""
        now = self._encoder_state if is_encoder else self._true_state
        if steps == 0:
            return now.Eval(context)
        if not context.get_discrete_state(self._is_started)[0]:
            return moved_back(now.Eval(context), steps * self._delivery.step)
        start = (2 * (steps - 1) + is_encoder) * self._size
        return context.get_discrete_state(self._states).value()[start : start + self._size]

    def _late(self, context: Context) -> np.ndarray:
        """Returns the age (5,) of each sensor's sample in plant steps."""
        return self._delivery.delay + self._delivery.latency(self._draws.Eval(context))

    def _calc_sampled(self, context: Context, output: BasicVector) -> None:
        late, sampled = self._late(context), np.empty(self._size)
        for g, group in enumerate(GROUPS):
            replace_group(g, sampled, self._state(context, late[g], group == "joints"))
        output.set_value(sampled)

    def _calc_accelerometer(self, context: Context, output: BasicVector) -> None:
        steps = self._late(context)[ACCELEROMETER]
        before = self._state(context, steps + self._period_steps)
        output.set_value(np.concatenate([before, self._state(context, steps)]))

    def _calc_tool(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._state(context, self._late(context)[TOOL]))
