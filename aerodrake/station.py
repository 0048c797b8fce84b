"""All wiring: the station, the coordinator, and the closed loop of the two.

The *station* is what hardware would replace: plant and rotors (wired in `physics`),
wind, sensors and the low-level controllers. The *coordinator* is what runs on a companion computer:
reference, kinematics, pointing (if asked for), weight allocator, residual estimator,
MPC (or CLIK) and setpoint integrator. They meet in seven signals: `state`,
`external_acceleration`, `specific_thrust`, `disturbance` and `saturated` one way,
`base_setpoint` and `joint_setpoint` the other.

    event                           period, offset (defaults)     kind
    plant, rotors,
    base_delay (if any)              1 ms                         discrete
    sensors                         10 ms, before 0.25 ms         discrete
    sensor_noise, gust_noise,
    state_filter                    10 ms                         unrestricted, so first
    air, wind_force (if any wind)   10 ms                         discrete
    mpc or clik, equivalent_state,
    residual_estimator,
    weight_allocator,
    setpoint_integrator             20 ms                         discrete
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
from typing import Any

import numpy as np
from pydrake.common import RandomGenerator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import AffineSystem, RandomSource

from aerodrake.model.clik import InverseKinematics
from aerodrake.model.direction import make_direction
from aerodrake.model.equivalent_model import EquivalentModel
from aerodrake.model.horizon import stage_times
from aerodrake.model.joint_pid import JointPid
from aerodrake.model.kinematics import Kinematics
from aerodrake.model.mpc import MpcFormulation
from aerodrake.model.reference import make_reference
from aerodrake.model.scenario_network import network_for
from aerodrake.model.setpoint import SetpointLimits
from aerodrake.model.vehicle import Vehicle
from aerodrake.physics import add_physics
from aerodrake.scenario import Scenario
from aerodrake.sensors import make_sensors
from aerodrake.systems.arm_controller import ArmController
from aerodrake.systems.clik import ClikSystem
from aerodrake.systems.equivalent_state import EquivalentState
from aerodrake.systems.flight_controller import FlightController
from aerodrake.systems.kinematics import KinematicsSystem
from aerodrake.systems.learner_fault import make_learner_fault
from aerodrake.systems.mpc import MpcSystem
from aerodrake.systems.pointing import PointingSystem
from aerodrake.systems.reference import ReferenceSystem
from aerodrake.systems.residual_estimator import ResidualEstimator
from aerodrake.systems.setpoint_integrator import SetpointIntegrator
from aerodrake.systems.weight_allocator import WeightAllocator
from aerodrake.wind import make_wind


def make_station(scenario: Scenario) -> Diagram:
    """Plant, rotors, wind, sensors, and flight and arm controllers.

    Inputs: `base_setpoint` (9), `joint_setpoint` (3 n).
    Outputs: `sample` and what the filter makes of it, `state` (13 + 2 n each) and
    `external_acceleration` (3); `true_state`; `thrust` and `thrust_command` (k) N;
    `joint_torque` (n) N m; `specific_thrust` (1), `disturbance` (6) and `saturated` (1),
    of the flight controller; `wind_force` (3) N, in the world; `query_object`.
    """
    rates, rotor = scenario.rates, scenario.vehicle.rotor
    vehicle = Vehicle.load(scenario)
    builder = DiagramBuilder()

    plant, scene_graph, rotors, _ = add_physics(builder, scenario, vehicle)
    wind = builder.AddSystem(make_wind(scenario.wind, vehicle.joints, rates.sensor_period_s))
    flight_controller = builder.AddNamedSystem(
        "flight_controller",
        FlightController(
            scenario.flight, rotor, vehicle, rates.flight_period_s, offset=rates.plant_step_s / 2
        ),
    )
    sensors = builder.AddSystem(
        make_sensors(
            scenario.sensors,
            scenario.filter,
            rates,
            vehicle.trim_state,
            flight_controller.trim_acceleration,
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

    connect = builder.Connect
    connect(flight_controller.GetOutputPort("thrust_command"), rotors.get_input_port())
    connect(plant.get_state_output_port(), wind.GetInputPort("true_state"))
    connect(
        wind.GetOutputPort("generalized_force"), plant.GetInputPort("applied_generalized_force")
    )
    connect(arm_controller.GetOutputPort("joint_torque"), plant.get_actuation_input_port())
    connect(plant.get_state_output_port(), sensors.GetInputPort("true_state"))
    for port in ("acceleration", "reaction"):
        connect(flight_controller.GetOutputPort(port), sensors.GetInputPort(port))
    connect(sensors.GetOutputPort("state"), flight_controller.GetInputPort("state"))
    connect(sensors.GetOutputPort("state"), arm_controller.GetInputPort("state"))

    builder.ExportInput(flight_controller.GetInputPort("base_setpoint"), "base_setpoint")
    builder.ExportInput(arm_controller.GetInputPort("joint_setpoint"), "joint_setpoint")
    builder.ConnectInput("joint_setpoint", flight_controller.GetInputPort("joint_setpoint"))
    builder.ExportOutput(plant.get_state_output_port(), "true_state")
    builder.ExportOutput(rotors.get_output_port(), "thrust")
    builder.ExportOutput(scene_graph.get_query_output_port(), "query_object")
    for system, ports in (
        (sensors, ("sample", "state", "external_acceleration")),
        (flight_controller, ("thrust_command", "specific_thrust", "disturbance", "saturated")),
        (arm_controller, ("joint_torque",)),
        (wind, ("wind_force",)),
    ):
        for port in ports:
            builder.ExportOutput(system.GetOutputPort(port), port)
    return _named(builder.Build(), "station")


def make_coordinator(scenario: Scenario) -> Diagram:
    """Reference, kinematics, allocator, residual estimator, MPC or CLIK, setpoint integrator.

    Inputs: those of the station's outputs that it meets, as above.
    Outputs: `base_setpoint` (9), `joint_setpoint` (3 n) and `segment`, which tells both
    until the next tick (3 (3 + n) + 1); `reference` (6), `weights`
    (5), `u` (3 + n), `prediction` (3 (N + 1)), `status` (2), `delta` (3),
    `prediction_error` (3), `nominal_prediction_error` (3), `learner_health` (2).
    """
    period = scenario.rates.mpc_period_s
    vehicle = Vehicle.load(scenario)
    n = vehicle.joints
    model = EquivalentModel.of(scenario, n)
    limits = SetpointLimits.make(scenario.mpc, vehicle)
    builder = DiagramBuilder()

    stages_s = stage_times(scenario.mpc, period)
    curve = make_reference(scenario.reference, vehicle.p_E)
    reference = builder.AddNamedSystem(
        "reference", ReferenceSystem(curve, vehicle.p_E, scenario.settle_s, stages_s)
    )
    kinematics = builder.AddNamedSystem(
        "kinematics", KinematicsSystem(Kinematics(vehicle.robot), n, vehicle.p_O)
    )
    weight_allocator = builder.AddNamedSystem(
        "weight_allocator", WeightAllocator(scenario.allocation, period)
    )
    equivalent_state = builder.AddNamedSystem("equivalent_state", EquivalentState(model))
    residual_estimator = builder.AddNamedSystem(
        "residual_estimator",
        ResidualEstimator(network_for(scenario, n), model, scenario.residual),
    )
    # Named `mpc` or `clik`; the ports are the same.
    controller = builder.AddNamedSystem(
        scenario.controller,
        MpcSystem(MpcFormulation(scenario.mpc, model, limits, vehicle))
        if scenario.controller == "mpc"
        else ClikSystem(InverseKinematics(scenario.clik, scenario.mpc, model, limits, vehicle)),
    )
    setpoint_integrator = builder.AddNamedSystem(
        "setpoint_integrator",
        SetpointIntegrator(limits, np.concatenate([vehicle.p_B, vehicle.working]), period),
    )

    def connect(source: Any, source_port: str, target: Any, target_port: str = "") -> None:
        builder.Connect(
            source.GetOutputPort(source_port), target.GetInputPort(target_port or source_port)
        )

    connect(reference, "reference", kinematics)
    connect(reference, "horizon", controller)
    connect(reference, "d_g", weight_allocator)
    connect(equivalent_state, "x_0", controller)
    connect(equivalent_state, "x_0", residual_estimator)
    connect(kinematics, "distances", weight_allocator)
    connect(kinematics, "end_effector", controller)
    connect(weight_allocator, "weights", controller)
    connect(residual_estimator, "delta", controller)
    connect(controller, "u", setpoint_integrator)
    if (learner_fault := make_learner_fault(scenario)) is not None:
        builder.AddNamedSystem("learner_fault", learner_fault)
        connect(learner_fault, "fault", residual_estimator)
    for consumer in (controller, residual_estimator, equivalent_state):
        connect(setpoint_integrator, "base_setpoint", consumer)
        connect(setpoint_integrator, "joint_setpoint", consumer)

    builder.ExportInput(kinematics.GetInputPort("state"), "state")
    for consumer in (controller, residual_estimator, equivalent_state):
        builder.ConnectInput("state", consumer.GetInputPort("state"))
    if (direction := make_direction(scenario.orientation)) is not None:
        pointing = builder.AddNamedSystem(
            "pointing", PointingSystem(vehicle, direction, scenario.settle_s, stages_s)
        )
        connect(pointing, "pointing", controller)
        builder.ConnectInput("state", pointing.GetInputPort("state"))
    for port in ("external_acceleration", "specific_thrust", "disturbance"):
        builder.ExportInput(equivalent_state.GetInputPort(port), port)
    builder.ExportInput(residual_estimator.GetInputPort("saturated"), "saturated")
    for system, ports in (
        (setpoint_integrator, ("base_setpoint", "joint_setpoint", "segment")),
        (reference, ("reference",)),
        (controller, ("u", "prediction", "status", "weights", "delta")),
        (residual_estimator, ("prediction_error", "nominal_prediction_error", "learner_health")),
    ):
        for port in ports:
            builder.ExportOutput(system.GetOutputPort(port), port)
    return _named(builder.Build(), "coordinator")


def add_closed_loop(builder: DiagramBuilder, scenario: Scenario) -> dict[str, OutputPort]:
    """Adds station and coordinator, which flies it; returns all outputs of both by name."""
    station = builder.AddSystem(make_station(scenario))
    coordinator = builder.AddSystem(make_coordinator(scenario))
    for port in ("state", "external_acceleration", "specific_thrust", "disturbance", "saturated"):
        builder.Connect(station.GetOutputPort(port), coordinator.GetInputPort(port))
    for port in ("base_setpoint", "joint_setpoint"):
        builder.Connect(coordinator.GetOutputPort(port), station.GetInputPort(port))
    sides = (station, coordinator)
    ports = [side.get_output_port(i) for side in sides for i in range(side.num_output_ports())]
    return {port.get_name(): port for port in ports}


def make_closed_loop(scenario: Scenario) -> Diagram:
    """The coordinator flying the station; its outputs are all of both."""
    builder = DiagramBuilder()
    for name, port in add_closed_loop(builder, scenario).items():
        builder.ExportOutput(port, name)
    return _named(builder.Build(), "closed_loop")


def make_context(diagram: Diagram, seed: int) -> Context:
    """A Context of any of these diagrams, in trim, with its noise and gusts drawn from `seed`."""
    context = diagram.CreateDefaultContext()
    generator = RandomGenerator(seed)
    for system in _leaves(diagram):
        if isinstance(system, (RandomSource, AffineSystem)):
            system.SetRandomContext(system.GetMyMutableContextFromRoot(context), generator)
    return context


def _leaves(system: System) -> Iterator[System]:
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from _leaves(inner)
    else:
        yield system


def _named(diagram: Diagram, name: str) -> Diagram:
    diagram.set_name(name)
    return diagram
