"""Force of the wind on the base."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from aerodrake.model.vehicle.state import VehicleState
from aerodrake.model.vehicle.wind import drag_on_base
from aerodrake.scenario import Wind
from aerodrake.support.arguments import Count, Period, checked


class WindForce(LeafSystem):
    """Drag on the base with a zero-order hold.

    Ports:
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        in `air_velocity` (3): m/s, wind and gust, in the world.
        out `wind_force` (3): N, in the world, at the base's origin.
        out `generalized_force` (6 + n): `wind_force` on the velocities [omega_W, v_B, q'] of the
            plant; at the base's origin it acts on v_B alone.
    State:
        the force (3) N.
    Rate:
        `period`, by a discrete update that samples the velocities of its instant; the
        force acts on the plant from its next step on. No events in still air. Both outputs
        depend on the state alone, so that steps of the plant call no Python.

    Args:
        config: Drag coefficients.
        joints: Number n of joints.
        period: s.
        is_windy: False for still air, where the force is always zero.
    """

    @checked
    def __init__(self, config: Wind, joints: Count, period: Period, is_windy: bool):
        super().__init__()
        self._drag = config.quadratic_drag_n_s2_m2, config.linear_drag_n_s_m
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(joints))
        self._air_velocity = self.DeclareVectorInputPort("air_velocity", 3)
        self._force = self.DeclareDiscreteState(np.zeros(3))
        self.DeclareStateOutputPort("wind_force", self._force)
        self.DeclareVectorOutputPort(
            "generalized_force",
            6 + joints,
            self._calc_generalized_force,
            {self.discrete_state_ticket(self._force)},
        )
        if is_windy:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        air, x = self._air_velocity.Eval(context), self._true_state.Eval(context)
        discrete.set_value(drag_on_base(*self._drag, air, x))

    def _calc_generalized_force(self, context: Context, output: BasicVector) -> None:
        force = np.zeros(output.size())
        force[3:6] = context.get_discrete_state(self._force).value()
        output.set_value(force)
