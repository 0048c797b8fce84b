"""The coordinator: what runs on a companion computer, as a diagram.

From measurement and reference to setpoints of base and arm: guidance, kinematics,
pointing (if asked for), weight allocator, residual estimator, MPC (or CLIK) and
setpoint integrator; and the supervisor, which says in which mode it works. Rates
stand in `aerodrake.station`, which it meets in `STATION_INTERFACE`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.mpc.clik import InverseKinematics
from aerodrake.model.mpc.formulation import MpcFormulation
from aerodrake.model.mpc.horizon import stage_times
from aerodrake.model.reference.direction import make_direction
from aerodrake.model.residual.scenario_network import network_for
from aerodrake.model.setpoint.integration import SetpointLimits
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.supervision.safe_mode import SafeMotion
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import MPC_FAULTS, Scenario
from aerodrake.support.errors import file_at
from aerodrake.systems.clik import ClikSystem
from aerodrake.systems.equivalent_state import EquivalentState
from aerodrake.systems.faults.learner import make_learner_fault
from aerodrake.systems.faults.mpc import MpcFaultSystem
from aerodrake.systems.kinematics import KinematicsSystem
from aerodrake.systems.mpc import MpcSystem
from aerodrake.systems.pointing import PointingSystem
from aerodrake.systems.residual_estimator import ResidualEstimator
from aerodrake.systems.setpoint_integrator import SetpointIntegrator
from aerodrake.systems.supervisor import SupervisorSystem
from aerodrake.systems.weight_allocator import WeightAllocator
from aerodrake.wiring.guidance import make_guidance
from aerodrake.wiring.replacements import Replacements


def make_coordinator(scenario: Scenario, replacements: Replacements | None = None) -> Diagram:
    """Reference, kinematics, allocator, residual estimator, MPC or CLIK, setpoint integrator.

    Inputs: those of `STATION_INTERFACE`; and `followed` (3 (3 + n) + 1), the segment that
    setpoints are on where the station has the last word on it, unconnected otherwise.
    Outputs: `base_setpoint` (9), `joint_setpoint` (3 n) and `segment`, which tells both
    until the next tick (3 (3 + n) + 1); `reference` (6) and `reference_verdict` (1), as it
    is followed; `weights` (5), `u` (3 + n) and `plan` (P (3 + n)), what it is to be from the last
    tick on; `prediction` (3 (N + 1)), `status` (3), `delta` (3),
    `prediction_error` (3), `nominal_prediction_error` (3), `learner_health` (2); `mode` (1),
    `cause` (1) and `conditions` (K), of the supervisor; with an orientation task `tool_axis_d`
    (3), the desired direction of the tool's axis.

    Args:
        scenario: What is flown.
        replacements: Of systems in it; None for none.

    Raises:
        BadInput: if a system that is to be replaced is not in it.
    """
    period = scenario.rates.mpc_period_s
    vehicle = VehicleModel.load(scenario)
    n = vehicle.joints
    model = EquivalentModel.of(scenario, n)
    limits = SetpointLimits.make(scenario.mpc, vehicle)
    replacements = replacements or Replacements()
    builder = replacements.builder()

    guidance = builder.AddSystem(make_guidance(scenario, vehicle, replacements.part()))
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
        "setpoint_integrator", make_setpoint_integrator(scenario, vehicle)
    )
    supervisor = builder.AddNamedSystem("supervisor", make_supervisor(scenario, vehicle))

    def connect(source: Any, source_port: str, target: Any, target_port: str = "") -> None:
        builder.Connect(
            source.GetOutputPort(source_port), target.GetInputPort(target_port or source_port)
        )

    if any(isinstance(fault, MPC_FAULTS) for fault in scenario.faults):
        mpc_fault = builder.AddNamedSystem(
            "mpc_fault", MpcFaultSystem(scenario.faults, scenario.settle_s)
        )
        connect(mpc_fault, "fault", controller)
    connect(guidance, "reference", kinematics)
    connect(guidance, "horizon", controller)
    connect(guidance, "d_g", weight_allocator)
    connect(guidance, "reference_verdict", supervisor)
    connect(controller, "status", supervisor)
    connect(residual_estimator, "learner_health", supervisor)
    connect(supervisor, "mode", setpoint_integrator)
    connect(equivalent_state, "x_0", controller)
    connect(equivalent_state, "x_0", residual_estimator)
    connect(kinematics, "distances", weight_allocator)
    connect(kinematics, "end_effector", controller)
    connect(weight_allocator, "weights", controller)
    connect(residual_estimator, "delta", controller)
    connect(controller, "u", setpoint_integrator)
    if (learner_fault := make_learner_fault(scenario)) is not None:
        learner_fault = builder.AddNamedSystem("learner_fault", learner_fault)
        connect(learner_fault, "fault", residual_estimator)
    for consumer in (controller, residual_estimator, equivalent_state):
        connect(setpoint_integrator, "base_setpoint", consumer)
        connect(setpoint_integrator, "joint_setpoint", consumer)

    builder.ExportInput(kinematics.GetInputPort("state"), "state")
    for consumer in (controller, residual_estimator, equivalent_state, supervisor):
        builder.ConnectInput("state", consumer.GetInputPort("state"))
    with file_at(scenario.source, "orientation.file"):
        direction = make_direction(scenario.orientation)
    if direction is not None:
        pointing = builder.AddNamedSystem(
            "pointing",
            PointingSystem(
                vehicle, direction, scenario.settle_s, stage_times(scenario.mpc, period)
            ),
        )
        connect(pointing, "pointing", controller)
        builder.ConnectInput("state", pointing.GetInputPort("state"))
        builder.ExportOutput(pointing.GetOutputPort("tool_axis_d"), "tool_axis_d")
    for port in ("external_acceleration", "specific_thrust", "disturbance"):
        builder.ExportInput(equivalent_state.GetInputPort(port), port)
    builder.ExportInput(residual_estimator.GetInputPort("saturated"), "saturated")
    for port in ("saturated", "specific_thrust"):
        builder.ConnectInput(port, supervisor.GetInputPort(port))
    for port in ("sample_health", "rotor_effectiveness"):
        builder.ExportInput(supervisor.GetInputPort(port), port)
    builder.ExportInput(setpoint_integrator.GetInputPort("followed"), "followed")
    for system, ports in (
        (setpoint_integrator, ("base_setpoint", "joint_setpoint", "segment")),
        (guidance, ("reference", "reference_verdict")),
        (supervisor, ("mode", "cause", "conditions")),
        (controller, ("u", "plan", "prediction", "status", "weights", "delta")),
        (residual_estimator, ("prediction_error", "nominal_prediction_error", "learner_health")),
    ):
        for port in ports:
            builder.ExportOutput(system.GetOutputPort(port), port)
    diagram = builder.Build()
    diagram.set_name("coordinator")
    return diagram


def make_setpoint_integrator(scenario: Scenario, vehicle: VehicleModel) -> SetpointIntegrator:
    """That of the coordinator, from trim."""
    return SetpointIntegrator(
        SetpointLimits.make(scenario.mpc, vehicle),
        SafeMotion.make(scenario.supervisor, vehicle),
        np.concatenate([vehicle.p_B, vehicle.working]),
        scenario.rates.mpc_period_s,
    )


def make_supervisor(scenario: Scenario, vehicle: VehicleModel) -> SupervisorSystem:
    """That of the coordinator."""
    return SupervisorSystem(
        conditions(scenario.supervisor),
        vehicle,
        scenario.rates.sensor_period_s,
        scenario.rates.mpc_period_s,
    )
