"""Plant without controllers, the reference for the cost of the closed loop."""

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from aerodrake.model.low_level.thrust_allocation import trim_thrust
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.systems.rotors import make_rotors
from aerodrake.wiring.plant import make_plant
from aerodrake.wiring.table import Wiring

WIRING = Wiring(
    connections=(
        ("thrust_command", "y0", "rotors", "u0"),
        ("rotors", "y0", "plant", "thrust"),
        ("joint_torque", "y0", "plant", "joint_torque"),
        ("no_force", "y0", "plant", "generalized_force"),
    ),
    outputs=(("rotors", "y0", "thrust"), ("plant", "state", "true_state")),
)


def make_bare_plant(scenario: Scenario) -> Diagram:
    """Makes a diagram of plant and rotors at the constant trim input.

    It has no controllers: the vehicle drifts slowly by rounding errors. With Drake's plant it has
    no Python systems. Outputs: `thrust` (k) N, `true_state` (13 + 2 n; a `VehicleState`).
    """
    vehicle, rotor = VehicleModel.load(scenario), scenario.vehicle.rotor
    trim = trim_thrust(vehicle, rotor)
    builder = DiagramBuilder()
    builder.AddSystem(make_plant(scenario, vehicle))
    rotors = make_rotors(rotor, scenario.mismatch, trim, scenario.rates.plant_step_s)
    builder.AddNamedSystem("rotors", rotors)
    builder.AddNamedSystem("thrust_command", ConstantVectorSource(trim))
    builder.AddNamedSystem("joint_torque", ConstantVectorSource(vehicle.trim_torque))
    builder.AddNamedSystem("no_force", ConstantVectorSource(np.zeros(6 + vehicle.joints)))
    return WIRING.build(builder, "bare_plant")
