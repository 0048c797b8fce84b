"""The rotor monitor as a system."""

from typing import Annotated

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.sensing.sample_health import split_health
from aerodrake.model.supervision.rotor_monitor import (
    NO_SAMPLE,
    MomentumSample,
    RotorMonitor,
    RotorMonitorState,
    update_monitor,
)
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody
from aerodrake.support.arguments import Timed, checked
from aerodrake.systems.named_state import NamedState


class RotorMonitorSystem(LeafSystem):
    """Estimates the fraction of its commanded thrust that each rotor gives.

    Ports:
        in `sample` (13 + 2 n): the last sample, a `VehicleState`; its base is
            `monitor.delay_samples` late.
        in `sample_health` (6): s since the last accepted sample of each group, then the
            groups' verdicts. Rejected samples do not change the estimate. If it is
            not connected, all finite samples are accepted.
        in `thrust_command` (k): N.
        out `rotor_effectiveness` (k): estimated fractions, 1 for a healthy rotor.
    State:
        the fields of `RotorMonitorState`, a group each.
    Rate:
        `period`, at its multiples: it reads the sample of the instant, and the thrust command
        that was applied since the previous sample.

    Args:
        monitor: The equations; its `lag.dt` is `period`.
        vehicle: Its links, whose momentum is balanced.
    """

    @checked
    def __init__(self, monitor: Annotated[RotorMonitor, Timed("lag.dt")], vehicle: VehicleModel):
        super().__init__()
        self._monitor = monitor
        self._whole_body = WholeBody(vehicle.plant)
        rotors = len(monitor.trim)
        self._sample = self.DeclareVectorInputPort("sample", VehicleState.size(vehicle.joints))
        self._health = self.DeclareVectorInputPort("sample_health", 6)
        self._command = self.DeclareVectorInputPort("thrust_command", rotors)
        self._state = NamedState(self, RotorMonitorState.initial(monitor))
        self._loss = self._state.groups["loss"]
        self.DeclareVectorOutputPort(
            "rotor_effectiveness",
            rotors,
            self._calc_effectiveness,
            {self.discrete_state_ticket(self._loss)},
        )
        self.DeclarePeriodicDiscreteUpdateEvent(monitor.lag.dt, 0.0, self._update)

    def _calc_effectiveness(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(1.0 - context.get_discrete_state(self._loss).value())

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        x, sample = self._sample.Eval(context), NO_SAMPLE
        is_valid = bool(np.all(np.isfinite(x)))
        if self._health.HasValue(context):
            is_valid &= not split_health(self._health.Eval(context)).ages.any()
        if is_valid:
            sample = MomentumSample(*self._whole_body.momentum(x), split_state(x).quaternion)
        last, command = self._state.read(context), self._command.Eval(context)
        self._state.write(discrete, update_monitor(self._monitor, last, command, sample))
