"""The rotor monitor as a system."""

from __future__ import annotations

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.supervision.rotor_monitor import RotorMonitor, watch
from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.model.vehicle.whole_body import WholeBody

GROUPS = 3
"""Of samples: position, attitude and joints."""


class RotorMonitorSystem(LeafSystem):
    """Tells what share of its commanded thrust each rotor gives.

    Ports:
        in `sample` (13 + 2 n): the last sample; its base is `monitor.steps` late.
        in `sample_health` (6): s since the last sample of each group that was believed,
            first. Of samples that were not nothing is learned. If it is not
            connected all are believed.
        in `thrust_command` (k): N.
        out `rotor_effectiveness` (k): estimated shares, 1 for a healthy rotor.
    State:
        what is remembered (35 + 4 k + k steps), as `RotorMonitor` has it, and the output.
    Rate:
        `period`, at its multiples: it sees the sample of its instant, and the command that
        has acted since the one before.

    Args:
        monitor: The equations; its samples are `period` apart.
        vehicle: Its links, of whose momentum it keeps account.
    """

    def __init__(self, monitor: RotorMonitor, vehicle: VehicleModel):
        super().__init__()
        self._monitor = monitor
        self._whole_body = WholeBody(vehicle.robot)
        rotors = len(monitor.trim)
        self._sample = self.DeclareVectorInputPort("sample", VehicleState.size(vehicle.joints))
        self._health = self.DeclareVectorInputPort("sample_health", 2 * GROUPS)
        self._command = self.DeclareVectorInputPort("thrust_command", rotors)
        self._x_memory = self.DeclareDiscreteState(monitor.initial_memory())
        self._x_effectiveness = self.DeclareDiscreteState(np.ones(rotors))
        self.DeclareStateOutputPort("rotor_effectiveness", self._x_effectiveness)
        self.DeclarePeriodicDiscreteUpdateEvent(monitor.lag.dt, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        sample = self._sample.Eval(context)
        is_believed = bool(np.all(np.isfinite(sample)))
        if self._health.HasValue(context):
            is_believed &= not self._health.Eval(context)[:GROUPS].any()
        motion = np.zeros(13)
        if is_believed:
            motion[:9], motion[9:] = self._whole_body.momentum(sample), sample[:4]
        memory, effectiveness = watch(
            self._monitor,
            discrete.value(self._x_memory),  # As in the context: an update begins with it.
            self._command.Eval(context),
            motion,
            is_believed,
        )
        discrete.set_value(self._x_memory, memory)
        discrete.set_value(self._x_effectiveness, effectiveness)
