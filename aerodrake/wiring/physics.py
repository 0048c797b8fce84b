"""Wiring of the physics: rotors, plant, wind, and the sum of the forces on the vehicle."""

from pydrake.systems.framework import Diagram
from pydrake.systems.primitives import Adder

from aerodrake.model.low_level.thrust_allocation import trim_thrust
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.systems.faults.actuators import make_rotor_faults
from aerodrake.systems.rotor_air import make_rotor_air
from aerodrake.systems.rotor_commands import make_rotor_dead_time, make_rotor_levels
from aerodrake.systems.rotor_strength import make_rotor_strength
from aerodrake.systems.rotors import make_rotors
from aerodrake.wiring.plant import make_plant
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs
from aerodrake.wiring.wind import make_wind

WIRING = Wiring(
    connections=(
        ("rotors", "y0", "plant", "thrust"),
        ("plant", "state", "wind", "true_state"),
        ("wind", "generalized_force", "forces", "u0"),
        ("forces", "sum", "plant", "generalized_force"),
    ),
    inputs=(
        ("thrust_command", "rotors", "u0"),
        ("joint_torque", "plant", "joint_torque"),
        ("external_force", "forces", "u1"),
    ),
    outputs=(
        ("plant", "state", "true_state"),
        ("rotors", "y0", "thrust"),
        *outputs("plant", "body_poses"),
        *outputs("wind", "wind_velocity", "wind_force"),
    ),
)

ROTOR_AIR = Wiring(
    connections=(
        ("plant", "state", "rotor_air", "true_state"),
        ("wind", "wind_velocity", "rotor_air", "wind_velocity"),
        ("rotor_air", "generalized_force", "forces", "u2"),
    ),
)
"""Connections of the effects of the air on the rotors, if there are any."""


@checked
def make_physics(
    scenario: Scenario, vehicle: VehicleModel, replacements: Replacements | None = None
) -> Diagram:
    """Makes the physics: rotors, plant and wind, in trim by default.

    A system with these ports can replace it, by the name `physics`; one with the ports of
    `aerodrake.wiring.plant.make_plant` can replace the plant alone.

    Inputs: `thrust_command` (k) N; `joint_torque` (n) N m, as it acts; `external_force` (6 + n),
    a generalized force on the plant's velocities [omega_W, v_B, q']: torque in N m and force in N
    on the base, in the world, at its origin, and torques in N m on the joints.
    Outputs: `true_state` (13 + 2 n), a `VehicleState`; `thrust` (k) N, as it acts. Optional:
    `body_poses` (abstract), as of the plant; `wind_velocity` (3) m/s, of the air at the base, and
    `wind_force` (3) N on it, in the world.

    Args:
        scenario: Vehicle, payload, mismatch, wind, air, rotors with their flaws and faults, rates.
        vehicle: The scenario's vehicle.
        replacements: Replacements of its systems; None for none.

    Raises:
        BadInput: if the scenario's robot is invalid, or a replacement does not fit.
    """
    replacements = replacements or Replacements()
    rates, rotor = scenario.rates, scenario.vehicle.rotor
    builder, trim = replacements.builder(), trim_thrust(vehicle, rotor)
    builder.AddSystem(make_plant(scenario, vehicle, replacements.part()))
    rotors = make_rotors(rotor, scenario.mismatch, trim, rates.plant_step_s)
    builder.AddNamedSystem("rotors", rotors)
    builder.AddSystem(
        make_wind(scenario.wind, vehicle.joints, rates.sensor_period_s, replacements.part())
    )
    wiring, summands = WIRING, 2
    for name, system in {
        "rotor_dead_time": make_rotor_dead_time(scenario.actuation, trim, rates.plant_step_s),
        "rotor_levels": make_rotor_levels(scenario.actuation, rotor, len(trim)),
    }.items():
        if system is not None:
            builder.AddNamedSystem(name, system)
            wiring = wiring.insert_before(name, ("rotors", "u0"))
    if (rotor_air := make_rotor_air(scenario.air, vehicle)) is not None:
        builder.AddNamedSystem("rotor_air", rotor_air)
        wiring = wiring.insert("rotor_air", ("rotors", "y0"), "thrust", "thrust") + ROTOR_AIR
        summands += 1
    for name, system in {
        "rotor_faults": make_rotor_faults(scenario, len(trim)),
        "rotor_strength": make_rotor_strength(scenario, len(trim)),
    }.items():
        if system is not None:
            builder.AddNamedSystem(name, system)
            wiring = wiring.insert(name, ("rotors", "y0"))
    builder.AddNamedSystem("forces", Adder(summands, 6 + vehicle.joints))
    return wiring.build(builder, "physics")
