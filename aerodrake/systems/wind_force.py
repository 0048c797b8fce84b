"""The force of the wind on the base, as the plant takes it."""

from __future__ import annotations

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from aerodrake.model.vehicle_state import VehicleState
from aerodrake.model.wind import drag_on_base, is_at_rest
from aerodrake.scenario import Wind


class WindForce(LeafSystem):
    """Samples the drag on the base and holds it: none, ever, where the air is at rest.

    Ports:
        in `true_state` (13 + 2 n): the plant's state.
        in `air_velocity` (3): m/s, wind and gust, in the world.
        out `wind_force` (3): N, in the world, at the base's origin.
        out `spatial_forces`: the same as a list of `ExternallyAppliedSpatialForce`.
    State:
        the last force.
    Rate:
        `period`, by a discrete update: it sees the velocities of its instant,
        and the plant feels the force from its next step on. Without any event
        if the air is at rest. Both outputs change with the state alone, so that
        the plant's own steps call no Python.

    Args:
        config: Drag, and whether the air moves.
        joints: n.
        base: Index of the base's body in the plant.
        period: s.
    """

    def __init__(self, config: Wind, joints: int, base: BodyIndex, period: float):
        super().__init__()
        self._drag = config.quadratic_drag_n_s2_m2, config.linear_drag_n_s_m
        self._base = base
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(joints))
        self._air_velocity = self.DeclareVectorInputPort("air_velocity", 3)
        self._force = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("wind_force", self._force)
        self.DeclareAbstractOutputPort(
            "spatial_forces",
            lambda: AbstractValue.Make([ExternallyAppliedSpatialForce()]),
            self._calc_spatial_forces,
            {self.discrete_state_ticket(self._force)},
        )
        if not is_at_rest(config):
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        air, x = self._air_velocity.Eval(context), self._true_state.Eval(context)
        discrete.set_value(drag_on_base(*self._drag, air, x))

    def _calc_spatial_forces(self, context: Context, output: AbstractValue) -> None:
        force = ExternallyAppliedSpatialForce()
        force.body_index = self._base
        force.p_BoBq_B = np.zeros(3)
        held = context.get_discrete_state(self._force).value()
        force.F_Bq_W = SpatialForce(tau=np.zeros(3), f=held)
        output.set_value([force])
