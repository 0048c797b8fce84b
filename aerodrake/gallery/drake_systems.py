"""Descriptions of Drake's own systems in the diagrams, in the form of a system's docstring."""

from pydrake.systems.framework import System

from aerodrake.gallery.docstring import Docstring
from aerodrake.systems.faults.actuators import make_joint_faults, make_pushes, make_rotor_faults
from aerodrake.systems.rotor_commands import make_rotor_dead_time, make_rotor_levels
from aerodrake.systems.rotor_strength import make_rotor_strength
from aerodrake.systems.rotors import make_propellers, make_rotors

PLANT = """
The rigid bodies of vehicle, payload and ground, with contact; one discrete step a plant step.

Ports:
    in `geometry_query` (abstract): query object of the scene graph, for contact.
    in `actuation` (n): N m, torques of all joint motors.
    in `applied_generalized_force` (nv): generalized force on the velocities, in N and N m.
    in `applied_spatial_force` (abstract): list of forces and torques on bodies, of the propellers.
    in `desired_state` (2 n): setpoints of Drake's joint controllers; not connected here.
    out `geometry_pose` (abstract): poses of the bodies' geometry in the world, for the scene graph.
    out `deformable_body_configuration` (abstract): of deformable bodies; there are none.
    out `state` (nq + nv): positions q and velocities v: for one vehicle a `VehicleState`.
    out `body_poses` (abstract): pose of each body in the world.
    out `body_spatial_velocities` (abstract): angular and linear velocity of each body.
    out `body_spatial_accelerations` (abstract): derivatives of the bodies' spatial velocities.
    out `generalized_acceleration` (nv): derivative of v.
    out `generalized_contact_forces` (nv): contact forces as generalized forces, in N and N m.
    out `net_actuation` (n): N m, torques that act on the joints, within the motors' limits.
    out `reaction_forces` (abstract): force and torque at each joint, on the outer body.
    out `contact_results` (abstract): points, forces and velocities of all contacts.
State:
    `x` (nq + nv), as the output `state`.
Rate:
    `rates.plant_step_s` of a scenario.
"""

SCENE_GRAPH = """
The collision geometry of all bodies, for contact.

Ports:
    in `multibody_plant_pose` (abstract): poses of the bodies' geometry in the world.
    in `multibody_plant_configuration` (abstract): of deformable bodies; not connected.
    out `query` (abstract): query object for distances and contacts.
"""

FORCES = """
Sum of the forces on the vehicle, as generalized forces on the plant's velocities.

Ports:
    in `u0` (6 + n): force of the wind.
    in `u1` (6 + n): external force, such as pushes.
    in `u2` (6 + n): drag of the rotors, only with effects of the air on them.
    out `sum` (6 + n): their sum, in N and N m.
"""

RANDOM_SOURCE = """
Random numbers, independent of each other, from the seed of the Context.

Ports:
    out `output` (m): samples of the distribution, constant between updates.
State:
    `x` (m): the last samples; and the generator, an abstract state.
Rate:
    an unrestricted update at the period of its diagram, for example `rates.sensor_period_s`.
"""

AIR = """
Velocity of the air: mean wind, and gusts as a discretised Ornstein-Uhlenbeck process.

Ports:
    in `u0` (3): Gaussian noise of unit variance.
    out `y0` (3): m/s, velocity of the air in the world.
State:
    `x` (3): m/s, gust.
Rate:
    `rates.sensor_period_s` of a scenario.
"""

DEVIATION = """
Deviation of the state from trim, since a delay begins with zeros.

Ports:
    in `u0` (13 + 2 n): true state.
    out `y0` (13 + 2 n): the true state minus that in trim.
"""

BASE_DELAY = """
Delay of the base's sensors, `sensors.base_delay_s` of a scenario.

Ports:
    in `u` (13 + 2 n): deviation of the state from trim.
    out `delayed_u` (13 + 2 n): deviation before the delay; zero at first.
State:
    `x`: the deviations of the last steps.
Rate:
    `rates.plant_step_s` of a scenario.
"""

LATE_STATE = """
The delayed state from its deviation.

Ports:
    in `u0` (13 + 2 n): delayed deviation of the state from trim.
    out `y0` (13 + 2 n): the delayed true state.
"""

COMMAND_DEVIATION = """
Deviation of the thrust commands from trim, since a delay begins with zeros.

Ports:
    in `u0` (k): N, commanded thrusts.
    out `y0` (k): N, the commands minus those in trim.
"""

COMMAND_DELAY = """
Dead time of the rotors, `actuation.rotor_dead_time_s` of a scenario.

Ports:
    in `u` (k): N, deviation of the commands from trim.
    out `delayed_u` (k): N, deviation before the dead time; zero at first.
State:
    `x`: the deviations of the last steps.
Rate:
    `rates.plant_step_s` of a scenario.
"""

LATE_COMMAND = """
The delayed commands from their deviation.

Ports:
    in `u0` (k): N, delayed deviation of the commands from trim.
    out `y0` (k): N, the delayed commands.
"""

BY_NAME: dict[str, object] = {
    "rotors": make_rotors,
    "propellers": make_propellers,
    "rotor_levels": make_rotor_levels,
    "rotor_dead_time": make_rotor_dead_time,
    "rotor_strength": make_rotor_strength,
    "rotor_faults": make_rotor_faults,
    "joint_faults": make_joint_faults,
    "pushes": make_pushes,
    "forces": FORCES,
    "air": AIR,
    "deviation": DEVIATION,
    "base_delay": BASE_DELAY,
    "late_state": LATE_STATE,
    "command_deviation": COMMAND_DEVIATION,
    "command_delay": COMMAND_DELAY,
    "late_command": LATE_COMMAND,
}
"""Function that makes a system, or its description, by the system's name."""

BY_CLASS: dict[str, object] = {
    "MultibodyPlant": PLANT,
    "SceneGraph": SCENE_GRAPH,
    "RandomSource": RANDOM_SOURCE,
}
"""Descriptions by class."""


def description(system: System) -> Docstring:
    """Returns the description of one of Drake's systems; empty if there is none."""
    thing = BY_NAME.get(system.get_name()) or BY_CLASS.get(type(system).__name__.split("[")[0])
    return Docstring.parse(thing) if isinstance(thing, str) else Docstring.of(thing)


def port_description(system: System, side: str, name: str) -> str:
    """Returns the meaning of a port of one of Drake's systems; empty if there is none.

    A plant has ports for each model too; their names are `MODEL_NAME`.

    Args:
        system: The system.
        side: `in` or `out`.
        name: Name of the port.
    """
    ports = description(system).ports
    if (side, name) in ports:
        return ports[side, name]
    own = max((n for at, n in ports if at == side and name.endswith(f"_{n}")), key=len, default="")
    return f"of the model `{name.removesuffix(f'_{own}')}`: {ports[side, own]}" if own else ""
