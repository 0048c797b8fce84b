"""Wind at the place of the vehicle as a system."""

from pydrake.systems.framework import BasicVector, Context, LeafSystem

from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.model.vehicle.wind import WindField, wind_at
from aerodrake.scenario import Wind
from aerodrake.support.arguments import Count, checked


class WindFieldSystem(LeafSystem):
    """Wind that varies with the position of the base.

    Ports:
        in `air_velocity` (3): m/s, wind and gust at the reference height, in the world.
        in `true_state` (13 + 2 n): `VehicleState` of the plant.
        out `wind_velocity` (3): m/s, velocity of the air at the base, in the world.
    State, rate:
        none; feeds through.

    Args:
        config: The field.
        joints: Number n of joints.
    """

    @checked
    def __init__(self, config: Wind, joints: Count):
        super().__init__()
        self._field = WindField.make(config)
        self._air_velocity = self.DeclareVectorInputPort("air_velocity", 3)
        self._true_state = self.DeclareVectorInputPort("true_state", VehicleState.size(joints))
        ports = self._air_velocity, self._true_state
        self.DeclareVectorOutputPort(
            "wind_velocity", 3, self._calc_velocity, {port.ticket() for port in ports}
        )

    def _calc_velocity(self, context: Context, output: BasicVector) -> None:
        p_B = split_state(self._true_state.Eval(context)).p_B
        output.set_value(wind_at(self._field, self._air_velocity.Eval(context), p_B))
