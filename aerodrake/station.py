"""All wiring: the station, the coordinator, and the closed loop of the two.

The *station* is what hardware would replace: plant and rotors (wired in `physics`),
wind, sensors and the low-level controllers. The *coordinator* is what runs on a companion computer:
reference, kinematics, pointing (if asked for), weight allocator, residual estimator,
MPC (or CLIK), setpoint integrator, and the supervisor, which says in which mode it
works. They meet in nine signals: those of `STATION_INTERFACE` one way, `base_setpoint` and
`joint_setpoint` the other. Either may be in another process: `remote_coordinator` says how
they meet there. `physics`, `sensors`, `wind` and `guidance` have pages of their own. What a
scenario's `faults` inject stands between systems, and only where it has some.

    event                           period, offset (defaults)     kind
    plant, rotors,
    base_delay (if any)              1 ms                         discrete
    sensors                         10 ms, before 0.25 ms         discrete
    sensor_noise, gust_noise,
    state_filter                    10 ms                         unrestricted, so first
    rotor_monitor,
    air, wind_force (if any wind)   10 ms                         discrete
    mpc or clik, equivalent_state,
    reference_guard,
    residual_estimator,
    weight_allocator,
    setpoint_integrator             20 ms                         discrete
    supervisor                      10 ms                         discrete
    flight_controller               10 ms, after 0.5 ms           discrete
    arm_controller                   5 ms, after 0.5 ms           discrete

A sample is taken a quarter of a plant step before its instant, when the plant's
state is that of the instant already: all that happens there sees it. The
low-level controllers run half a plant step after: late enough to see what the
MPC commanded, in time for the plant's next step. Neither is ever at an instant
whose order with others would be a matter of rounding. What the coordinator
learns of the low-level controllers at a sample is of their command before.
"""

from __future__ import annotations

from collections.abc import Iterator

from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import AffineSystem, RandomSource

from aerodrake.coordinator import make_coordinator
from aerodrake.model.low_level.joint_pid import JointPid
from aerodrake.model.supervision.rotor_monitor import RotorMonitor
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.systems.arm_controller import ArmController
from aerodrake.systems.faults.actuators import make_joint_faults, make_pushes
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.rotor_monitor import RotorMonitorSystem
from aerodrake.wiring.physics import add_physics, through
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.sensors import make_sensors
from aerodrake.wiring.wind import make_wind

STATION_INTERFACE = (
    "state",
    "sample_health",
    "external_acceleration",
    "specific_thrust",
    "disturbance",
    "saturated",
    "rotor_effectiveness",
)
"""What the coordinator is told by the station, by name."""


def make_station(scenario: Scenario, replacements: Replacements | None = None) -> Diagram:
    """Plant, rotors, wind, sensors, and flight and arm controllers.

    Inputs: `base_setpoint` (9), `joint_setpoint` (3 n).
    Outputs: `sample` and what the filter makes of it, `state` (13 + 2 n each),
    `external_acceleration` (3) and `sample_health` (6); `true_state`; `thrust` (k) N and
    `joint_torque` (n) N m, as they act; `thrust_command` (k) N, `specific_thrust` (1),
    `disturbance` (6) and `saturated` (1), of the flight controller; `rotor_effectiveness` (k);
    `wind_force` (3) N, in the world; `query_object`.

    Args:
        scenario: What is flown.
        replacements: Of systems in it; None for none.

    Raises:
        BadInput: if a system that is to be replaced is not in it, or cannot be.
    """
    rates, rotor = scenario.rates, scenario.vehicle.rotor
    vehicle = VehicleModel.load(scenario)
    replacements = replacements or Replacements()
    builder = replacements.builder()

    plant, scene_graph, rotors, thrust, trim = add_physics(builder, scenario, vehicle)
    wind = builder.AddSystem(
        make_wind(scenario.wind, vehicle.joints, rates.sensor_period_s, replacements.part())
    )
    controller = FlightController(
        scenario.flight, rotor, vehicle, rates.flight_period_s, offset=rates.plant_step_s / 2
    )
    flight_controller = builder.AddNamedSystem("flight_controller", controller)
    sensors = builder.AddSystem(
        make_sensors(
            scenario.sensors,
            scenario.filter,
            rates,
            vehicle.trim_state,
            controller.trim_acceleration,
            scenario.faults,
            scenario.settle_s,
            replacements.part(),
        )
    )
    arm_controller = builder.AddNamedSystem(
        "arm_controller",
        ArmController(
            JointPid.make(scenario.arm, vehicle, rates.arm_period_s),
            vehicle,
            offset=rates.plant_step_s / 2,
        ),
    )

    rotor_monitor = builder.AddNamedSystem(
        "rotor_monitor",
        RotorMonitorSystem(
            RotorMonitor.make(vehicle, rotor, trim, scenario.filter.delay_s, rates.sensor_period_s),
            vehicle,
        ),
    )

    connect = builder.Connect
    connect(flight_controller.GetOutputPort("thrust_command"), rotors.get_input_port())
    connect(plant.get_state_output_port(), wind.GetInputPort("true_state"))
    joint_faults = make_joint_faults(scenario, vehicle.joints)
    pushes = make_pushes(scenario, vehicle.joints)
    torque = arm_controller.GetOutputPort("joint_torque")
    torque = through(builder, torque, joint_faults, "joint_faults")
    connect(torque, plant.get_actuation_input_port())
    force = through(builder, wind.GetOutputPort("generalized_force"), pushes, "pushes")
    connect(force, plant.GetInputPort("applied_generalized_force"))
    connect(plant.get_state_output_port(), sensors.GetInputPort("true_state"))
    for port in ("acceleration", "reaction"):
        connect(flight_controller.GetOutputPort(port), sensors.GetInputPort(port))
    connect(sensors.GetOutputPort("state"), flight_controller.GetInputPort("state"))
    for system, port in (
        (sensors, "sample"),
        (sensors, "sample_health"),
        (flight_controller, "thrust_command"),
    ):
        connect(system.GetOutputPort(port), rotor_monitor.GetInputPort(port))
    connect(sensors.GetOutputPort("state"), arm_controller.GetInputPort("state"))

    builder.ExportInput(flight_controller.GetInputPort("base_setpoint"), "base_setpoint")
    builder.ExportInput(arm_controller.GetInputPort("joint_setpoint"), "joint_setpoint")
    for consumer in (flight_controller, sensors):
        builder.ConnectInput("joint_setpoint", consumer.GetInputPort("joint_setpoint"))
    builder.ExportOutput(plant.get_state_output_port(), "true_state")
    builder.ExportOutput(thrust, "thrust")
    builder.ExportOutput(torque, "joint_torque")
    builder.ExportOutput(scene_graph.get_query_output_port(), "query_object")
    for system, ports in (
        (sensors, ("sample", "state", "external_acceleration", "sample_health")),
        (flight_controller, ("thrust_command", "specific_thrust", "disturbance", "saturated")),
        (rotor_monitor, ("rotor_effectiveness",)),
        (wind, ("wind_force",)),
    ):
        for port in ports:
            builder.ExportOutput(system.GetOutputPort(port), port)
    return _named(builder.Build(), "station")


def add_closed_loop(
    builder: DiagramBuilder,
    scenario: Scenario,
    replacements: Replacements | None = None,
    coordinator: Diagram | None = None,
) -> dict[str, OutputPort]:
    """Adds station and coordinator, which flies it; returns all outputs of both by name.

    Args:
        builder: To which they are added.
        scenario: Of both.
        replacements: Of systems in them; None for none.
        coordinator: One that flies in the place of the scenario's, such as the end of a wire to it.

    Raises:
        BadInput: if a system that is to be replaced is in neither, or cannot be.
    """
    replacements = replacements or Replacements()
    station, coordinator = (
        builder.AddSystem(replacements.instead_of(side.get_name(), side))
        for side in (
            make_station(scenario, replacements.part()),
            coordinator or make_coordinator(scenario, replacements.part()),
        )
    )
    replacements.check_met()
    for port in STATION_INTERFACE:
        builder.Connect(station.GetOutputPort(port), coordinator.GetInputPort(port))
    for port in ("base_setpoint", "joint_setpoint"):
        builder.Connect(coordinator.GetOutputPort(port), station.GetInputPort(port))
    sides = (station, coordinator)
    ports = [side.get_output_port(i) for side in sides for i in range(side.num_output_ports())]
    return {port.get_name(): port for port in ports}


def make_closed_loop(scenario: Scenario, replacements: Replacements | None = None) -> Diagram:
    """The coordinator flying the station; its outputs are all of both."""
    builder = DiagramBuilder()
    for name, port in add_closed_loop(builder, scenario, replacements).items():
        builder.ExportOutput(port, name)
    return _named(builder.Build(), "closed_loop")


def make_context(diagram: Diagram, seed: int) -> Context:
    """A Context of any of these diagrams, in trim, with its noise and gusts drawn from `seed`."""
    context = diagram.CreateDefaultContext()
    generator = RandomGenerator(seed)
    for system in leaf_systems(diagram):
        if isinstance(system, (RandomSource, AffineSystem)):
            system.SetRandomContext(system.GetMyMutableContextFromRoot(context), generator)
    return context


def leaf_systems(system: System) -> Iterator[System]:
    """Those in a diagram, however deep; a leaf system itself."""
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from leaf_systems(inner)
    else:
        yield system


def _named(diagram: Diagram, name: str) -> Diagram:
    diagram.set_name(name)
    return diagram
