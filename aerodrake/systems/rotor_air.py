"""Effects of the air on the rotors as a system between rotors and plant."""

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from aerodrake.model.vehicle.rotor_air import RotorAir, rotor_forces
from aerodrake.model.vehicle.state import BASE_VELOCITIES, VehicleState
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Air
from aerodrake.support.arguments import checked


class RotorAirSystem(LeafSystem):
    """Changes thrusts by inflow, ground and ceiling, and adds the rotors' drag.

    Ports:
        in `thrust` (k): N, without these effects.
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        in `wind_velocity` (3): m/s, velocity of the air at the base, in the world; still air if it
            is not connected.
        out `thrust` (k): N, as it acts.
        out `generalized_force` (6 + n): drag of the rotors on the plant's velocities
            [omega_W, v_B, q'].
    State, rate:
        none; feeds through, once a plant step.

    Args:
        config: The effects.
        vehicle: Positions of its rotors.
    """

    @checked
    def __init__(self, config: Air, vehicle: VehicleModel):
        super().__init__()
        self._air = RotorAir.make(config, vehicle.rotors)
        n, k = vehicle.joints, len(vehicle.rotors.names)
        self._thrust = self.DeclareVectorInputPort("thrust", k)
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(n))
        self._wind = self.DeclareVectorInputPort("wind_velocity", 3)
        self._forces = self.DeclareCacheEntry(
            "rotor_forces",
            ValueProducer(lambda: Value[object](None), self._calc_forces),
            {port.ticket() for port in (self._thrust, self._true_state, self._wind)},
        )
        tickets = {self._forces.ticket()}
        self.DeclareVectorOutputPort("thrust", k, self._calc_thrust, tickets)
        self.DeclareVectorOutputPort(
            "generalized_force", BASE_VELOCITIES + n, self._calc_generalized_force, tickets
        )

    def _calc_forces(self, context: Context, forces: AbstractValue) -> None:
        wind = self._wind.Eval(context) if self._wind.HasValue(context) else np.zeros(3)
        thrust, state = self._thrust.Eval(context), self._true_state.Eval(context)
        forces.set_value(rotor_forces(self._air, thrust, wind, state))

    def _calc_thrust(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._forces.Eval(context).thrust)

    def _calc_generalized_force(self, context: Context, output: BasicVector) -> None:
        output.SetZero()
        output.get_mutable_value()[:BASE_VELOCITIES] = self._forces.Eval(context).drag


@checked
def make_rotor_air(config: Air, vehicle: VehicleModel) -> RotorAirSystem | None:
    """Makes the effects of the air on a vehicle's rotors; None if there are none."""
    if not any((config.rotor_drag_n_s_m, config.inflow_s_m, config.rotor_radius_m)):
        return None
    return RotorAirSystem(config, vehicle)
