"""Top-level wiring of the station and of the closed loop.

The *station* is what real hardware replaces: physics (rotors, plant and wind), sensors and
low-level controllers. The *coordinator* is what runs on a companion computer: reference, weight
allocator, residual estimator, MPC, setpoint integrator and supervisor. The closed loop connects
the two by the signals in `STATION_INTERFACE` and `SETPOINTS`. The coordinator is wired in
`aerodrake.coordinator`, each sub-diagram in a module of `aerodrake.wiring`.

`RATES` lists the periodic events of both. The sensors run a quarter of a plant step before each
multiple of their period. A discrete plant then already has its state of that instant, so that all
events at the instant use the new sample. The low-level controllers run half a plant step after
the instant: they use the MPC's new setpoints, and the next plant step uses their commands. These
offsets make the order of events independent of rounding. The coordinator therefore sees the
outputs of the low-level controllers one sample late.
"""

import math
from collections.abc import Iterator

from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import AffineSystem, RandomSource

from aerodrake.coordinator import make_coordinator
from aerodrake.model.low_level.thrust_allocation import trim_thrust
from aerodrake.model.supervision.rotor_monitor import RotorMonitor
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import Seed, checked
from aerodrake.systems.arm_controller import ArmController
from aerodrake.systems.faults.actuators import make_pushes
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.joint_transmission import is_rigid
from aerodrake.systems.rotor_monitor import RotorMonitorSystem
from aerodrake.wiring.joints import add_joint_actuation
from aerodrake.wiring.physics import make_physics
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.sensors import make_sensors
from aerodrake.wiring.setpoint_link import make_setpoint_link
from aerodrake.wiring.table import Rate, Wiring, outputs, shared_input

RATES = (
    Rate(("plant", "rotors", "base_delay"), "plant_step_s"),
    Rate(("sampler",), "sensor_period_s", offset_steps=-1 / 4),
    Rate(("sensor_noise", "gust_noise", "state_filter"), "sensor_period_s", kind="unrestricted"),
    Rate(("rotor_monitor", "air", "wind_force", "supervisor"), "sensor_period_s"),
    Rate(("reference_guard", "weight_allocator", "equivalent_state"), "mpc_period_s"),
    Rate(("residual_estimator", "mpc", "clik", "setpoint_integrator"), "mpc_period_s"),
    Rate(("flight_controller",), "flight_period_s", offset_steps=1 / 2),
    Rate(("arm_controller",), "arm_period_s", offset_steps=1 / 2),
)
"""Periodic updates of all systems; values are in the section `rates` of a scenario, for example
`mpc_period_s`, 20 ms by default. The row of the plant is that of the system in it that has its
state. In still air the wind has no updates. Systems that only some scenarios have are not listed:
sample faults update with `sensor_period_s`, flaws of rotors and joints with `plant_step_s`, the
setpoint link with `mpc_period_s`."""

WIRING = Wiring(
    connections=(
        ("flight_controller", "thrust_command", "physics", "thrust_command"),
        ("arm_controller", "joint_torque", "physics", "joint_torque"),
        ("pushes", "y0", "physics", "external_force"),
        ("physics", "true_state", "sensors", "true_state"),
        ("flight_controller", "acceleration", "sensors", "acceleration"),
        ("flight_controller", "reaction", "sensors", "reaction"),
        ("sensors", "state", "flight_controller", "state"),
        ("sensors", "state", "arm_controller", "state"),
        ("sensors", "sample", "rotor_monitor", "sample"),
        ("sensors", "sample_health", "rotor_monitor", "sample_health"),
        ("flight_controller", "thrust_command", "rotor_monitor", "thrust_command"),
    ),
    inputs=(
        *shared_input("base_setpoint", "flight_controller"),
        *shared_input("joint_setpoint", "flight_controller", "arm_controller", "sensors"),
    ),
    outputs=(
        *outputs("arm_controller", "joint_torque", "torque_at_limit"),
        *outputs("sensors", "sample", "state", "external_acceleration", "sample_health"),
        *outputs("sensors", "joint_oscillation", "position_offset"),
        *outputs("sensors", "specific_force", "specific_force_stamp"),
        *outputs("sensors", "tool_position", "tool_stamp"),
        *outputs("flight_controller", "thrust_command", "specific_thrust"),
        *outputs("flight_controller", "disturbance", "saturated"),
        *outputs("rotor_monitor", "rotor_effectiveness"),
        *outputs("physics", "true_state", "thrust", "body_poses"),
        *outputs("physics", "wind_velocity", "wind_force"),
    ),
)

STATION_INTERFACE = (
    "state",
    "sample_health",
    "joint_oscillation",
    "torque_at_limit",
    "position_offset",
    "external_acceleration",
    "specific_thrust",
    "disturbance",
    "saturated",
    "rotor_effectiveness",
)
"""Signals from the station to the coordinator."""

SETPOINTS = ("base_setpoint", "joint_setpoint")
"""Signals from the coordinator to the station."""

INTERFACE = Wiring(tuple(("station", port, "coordinator", port) for port in STATION_INTERFACE))
DIRECT = Wiring(tuple(("coordinator", port, "station", port) for port in SETPOINTS))
LINKED = Wiring(
    (
        ("coordinator", "segment", "setpoint_link", "segment"),
        *(("setpoint_link", port, "station", port) for port in SETPOINTS),
    )
)
"""Connections of the closed loop; those of the setpoints are direct, or over a link with flaws."""


@checked
def make_station(
    scenario: Scenario,
    replacements: Replacements | None = None,
    vehicle: VehicleModel | None = None,
) -> Diagram:
    """Makes the station: physics, sensors, and flight and arm controllers.

    Inputs: `base_setpoint` (9), `joint_setpoint` (3 n).
    Outputs: `sample` and its filtered form `state` (13 + 2 n each), `external_acceleration` (3),
    `sample_health` (6), `joint_oscillation` (n) and `position_offset` (3); `true_state`
    (13 + 2 n); `thrust` (k) N and `joint_torque` (n) N m, as they act; `torque_at_limit` (n), of
    the arm controller; `thrust_command` (k) N, `specific_thrust` (1), `disturbance` (6) and
    `saturated` (1), of the flight controller; `rotor_effectiveness` (k); `body_poses`
    (abstract), `wind_velocity` (3) m/s and `wind_force` (3) N, of the physics. With an
    accelerometer, `specific_force` (3) m/s^2 in the base frame, the mean of its last samples, and
    its stamp `specific_force_stamp` (1) s. With a tool sensor, `tool_position` (3) m in the
    world, its last sample, and `tool_stamp` (1) s.
    Samples and states are `VehicleState`s, whose parts `split_state` names.

    Args:
        scenario: The scenario to fly.
        replacements: Replacements of its systems; None for none.
        vehicle: The scenario's vehicle, if it is loaded already.

    Raises:
        BadInput: if a system to be replaced does not exist, or a replacement does not fit.
    """
    rates, rotor = scenario.rates, scenario.vehicle.rotor
    vehicle = vehicle or VehicleModel.load(scenario)
    replacements = replacements or Replacements()
    builder, offset = replacements.builder(), rates.plant_step_s / 2
    builder.AddSystem(make_physics(scenario, vehicle, replacements.part()))
    builder.AddNamedSystem("pushes", make_pushes(scenario, vehicle.joints))
    flight_controller = FlightController(
        scenario.flight, rotor, vehicle, rates.flight_period_s, offset
    )
    builder.AddNamedSystem("flight_controller", flight_controller)
    builder.AddSystem(
        make_sensors(
            scenario,
            vehicle.trim_state,
            flight_controller.trim_acceleration,
            replacements.part(),
            vehicle,
            has_encoder_state=not is_rigid(scenario.actuation),
        )
    )
    arm_controller = ArmController(scenario.arm, vehicle, rates.arm_period_s, offset)
    builder.AddNamedSystem("arm_controller", arm_controller)
    monitor = RotorMonitor.make(
        vehicle,
        rotor,
        trim_thrust(vehicle, rotor),
        scenario.filter.delay_s,
        rates.sensor_period_s,
        math.lcm(*scenario.sensors.ticks(rates.sensor_period_s)),
    )
    builder.AddNamedSystem("rotor_monitor", RotorMonitorSystem(monitor, vehicle))
    wiring = add_joint_actuation(builder, scenario, vehicle, WIRING)
    return wiring.build(builder, "station")


@checked
def add_closed_loop(
    builder: DiagramBuilder,
    scenario: Scenario,
    replacements: Replacements | None = None,
    coordinator: Diagram | None = None,
    vehicle: VehicleModel | None = None,
) -> dict[str, OutputPort]:
    """Adds station and coordinator to a builder and connects them.

    Args:
        builder: The builder to add them to.
        scenario: The scenario to fly.
        replacements: Replacements of systems in either; None for none.
        coordinator: A coordinator to fly instead of the scenario's, such as a remote one.
        vehicle: The scenario's vehicle, if it is loaded already.

    Returns:
        All outputs of both, by name.

    Raises:
        BadInput: if a system to be replaced does not exist, or a replacement does not fit.
    """
    vehicle = vehicle or VehicleModel.load(scenario)
    replacements = replacements or Replacements()
    station = make_station(scenario, replacements.part(), vehicle)
    coordinator = coordinator or make_coordinator(scenario, replacements.part(), vehicle)
    sides = [
        builder.AddSystem(replacements.instead_of(side.get_name(), side))
        for side in (station, coordinator)
    ]
    wiring = INTERFACE + DIRECT
    if (link := make_setpoint_link(scenario, vehicle, replacements.part())) is not None:
        builder.AddSystem(replacements.instead_of(link.get_name(), link))
        wiring = INTERFACE + LINKED
    replacements.check_used()
    wiring.apply(builder)
    ports = [side.get_output_port(i) for side in sides for i in range(side.num_output_ports())]
    return {port.get_name(): port for port in ports}


@checked
def make_closed_loop(scenario: Scenario, replacements: Replacements | None = None) -> Diagram:
    """Makes the closed loop of station and coordinator; it has all outputs of both."""
    builder = DiagramBuilder()
    for name, port in add_closed_loop(builder, scenario, replacements).items():
        builder.ExportOutput(port, name)
    return Wiring().build(builder, "closed_loop")


def leaf_systems(system: System) -> Iterator[System]:
    """Yields the leaf systems of a diagram at any depth; a leaf system yields itself."""
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from leaf_systems(inner)
    else:
        yield system


@checked
def make_context(diagram: Diagram, seed: Seed) -> Context:
    """Makes a Context of one of these diagrams in trim, with random noise and gusts from `seed`."""
    context = diagram.CreateDefaultContext()
    generator = RandomGenerator(seed)
    for system in leaf_systems(diagram):
        if isinstance(system, (RandomSource, AffineSystem)):
            system.SetRandomContext(system.GetMyMutableContextFromRoot(context), generator)
    return context
