"""Plant without controllers, the reference for the cost of the closed loop."""

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.wiring.physics import add_physics
from aerodrake.wiring.table import Wiring

WIRING = Wiring(
    connections=(
        ("thrust_command", "y0", "rotors", "u0"),
        ("joint_torque", "y0", "plant", "actuation"),
    )
)


def make_bare_plant(scenario: Scenario) -> Diagram:
    """Makes a diagram of plant, scene graph, propellers and rotors at the constant trim input.

    It has no Python systems and no controllers: the vehicle drifts slowly by rounding
    errors. Outputs: `thrust` (k) N, `true_state` (13 + 2 n; a `VehicleState`), `query_object`.
    """
    vehicle = VehicleModel.load(scenario)
    builder = DiagramBuilder()
    trim_thrust, wiring = add_physics(builder, scenario, vehicle)
    builder.AddNamedSystem("thrust_command", ConstantVectorSource(trim_thrust))
    builder.AddNamedSystem("joint_torque", ConstantVectorSource(vehicle.trim_torque))
    return (wiring + WIRING).build(builder, "bare_plant")
