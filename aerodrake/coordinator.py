"""Top-level wiring of the coordinator, which runs on a companion computer.

It computes setpoints of base and arm from the measured state and the reference.
`aerodrake.station` lists the rates of its systems (`RATES`) and its signals from and to the
station (`STATION_INTERFACE` and `SETPOINTS`). Guidance is wired in `aerodrake.wiring.guidance`.
"""

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
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.support.errors import file_at
from aerodrake.systems.clik import ClikSystem
from aerodrake.systems.equivalent_state import EquivalentState
from aerodrake.systems.faults.learner import make_residual_estimator
from aerodrake.systems.faults.mpc import make_mpc
from aerodrake.systems.kinematics import KinematicsSystem
from aerodrake.systems.mpc import MpcSystem
from aerodrake.systems.pointing import PointingSystem
from aerodrake.systems.setpoint_integrator import SetpointIntegrator
from aerodrake.systems.supervisor import SupervisorSystem
from aerodrake.systems.weight_allocator import WeightAllocator
from aerodrake.wiring.guidance import make_guidance
from aerodrake.wiring.replacements import Replacements
from aerodrake.wiring.table import Wiring, outputs, shared_input

WIRING = Wiring(
    connections=(
        ("guidance", "reference", "kinematics", "reference"),
        ("guidance", "d_g", "weight_allocator", "d_g"),
        ("kinematics", "distances", "weight_allocator", "distances"),
        ("equivalent_state", "x_0", "residual_estimator", "x_0"),
        ("guidance", "horizon", "controller", "horizon"),
        ("kinematics", "end_effector", "controller", "end_effector"),
        ("weight_allocator", "weights", "controller", "weights"),
        ("equivalent_state", "x_0", "controller", "x_0"),
        ("residual_estimator", "delta", "controller", "delta"),
        ("controller", "u", "setpoint_integrator", "u"),
        ("setpoint_integrator", "base_setpoint", "equivalent_state", "base_setpoint"),
        ("setpoint_integrator", "joint_setpoint", "equivalent_state", "joint_setpoint"),
        ("setpoint_integrator", "base_setpoint", "residual_estimator", "base_setpoint"),
        ("setpoint_integrator", "joint_setpoint", "residual_estimator", "joint_setpoint"),
        ("setpoint_integrator", "base_setpoint", "controller", "base_setpoint"),
        ("setpoint_integrator", "joint_setpoint", "controller", "joint_setpoint"),
        ("guidance", "reference_verdict", "supervisor", "reference_verdict"),
        ("residual_estimator", "learner_health", "supervisor", "learner_health"),
        ("controller", "status", "supervisor", "status"),
        ("supervisor", "mode", "setpoint_integrator", "mode"),
    ),
    inputs=(
        *shared_input("state", "kinematics", "equivalent_state", "residual_estimator"),
        *shared_input("state", "controller", "supervisor", "setpoint_integrator"),
        *shared_input("position_offset", "setpoint_integrator"),
        *shared_input("external_acceleration", "equivalent_state"),
        *shared_input("specific_thrust", "equivalent_state", "supervisor"),
        *shared_input("disturbance", "equivalent_state"),
        *shared_input("saturated", "residual_estimator", "supervisor"),
        *shared_input("sample_health", "supervisor"),
        *shared_input("joint_oscillation", "supervisor"),
        *shared_input("torque_at_limit", "supervisor"),
        *shared_input("rotor_effectiveness", "supervisor"),
        *shared_input("followed", "setpoint_integrator"),
    ),
    outputs=(
        *outputs("setpoint_integrator", "base_setpoint", "joint_setpoint", "segment"),
        *outputs("guidance", "reference", "horizon", "reference_verdict"),
        *outputs("guidance", "requested_reference"),
        *outputs("supervisor", "mode", "cause", "conditions"),
        *outputs("controller", "u", "plan", "prediction", "status", "weights", "delta"),
        *outputs("residual_estimator", "prediction_error", "nominal_prediction_error"),
        *outputs("residual_estimator", "learner_health", "delta_source", "stable_learning_rate"),
    ),
)
"""Connections of the systems that all scenarios have; `controller` is `mpc` or `clik`."""

POINTING_WIRING = Wiring(
    connections=(("pointing", "pointing", "controller", "pointing"),),
    inputs=shared_input("state", "pointing"),
    outputs=outputs("pointing", "tool_axis_d", "tool_axis_horizon"),
)
"""Connections of the system that only scenarios with an orientation task have."""


@checked
def make_coordinator(
    scenario: Scenario,
    replacements: Replacements | None = None,
    vehicle: VehicleModel | None = None,
) -> Diagram:
    """Makes the coordinator: guidance, estimators, MPC or CLIK, setpoint integrator, supervisor.

    Inputs: those of `STATION_INTERFACE`; `followed` (3 (3 + n) + 1), the segment that the vehicle
    follows, if the station has a setpoint integrator of its own; unconnected otherwise.
    Outputs: `base_setpoint` (9), `joint_setpoint` (3 n) and `segment` (3 (3 + n) + 1), the
    polynomials of both until the next tick; `reference` (6) and `horizon` (6 (N + 1)), as the guard
    passes them on, `requested_reference` (6) before, and its `reference_verdict` (1);
    `weights` (5), `u` (3 + n) and `plan`
    (P (3 + n)), the inputs from the last tick on; `prediction` (3 (N + 1)), `status` (3);
    `delta` (3), `prediction_error` (3), `nominal_prediction_error` (3), `learner_health` (2),
    `delta_source` (1), `stable_learning_rate` (1);
    `mode` (1), `cause` (1) and `conditions` (K), of the supervisor; with an orientation task
    `tool_axis_d` (3) and `tool_axis_horizon` (6 (N + 1)), the desired direction of the tool's axis.

    Args:
        scenario: The scenario to fly.
        replacements: Replacements of its systems; None for none.
        vehicle: The scenario's vehicle, if it is loaded already.

    Raises:
        BadInput: if a system to be replaced does not exist, or a replacement does not fit.
    """
    period = scenario.rates.mpc_period_s
    vehicle = vehicle or VehicleModel.load(scenario)
    model = EquivalentModel.of(scenario, vehicle.joints)
    replacements = replacements or Replacements()
    builder = replacements.builder()
    builder.AddSystem(make_guidance(scenario, vehicle, replacements.part()))
    kinematics, wiring = Kinematics(vehicle.plant), WIRING
    systems = {
        "kinematics": KinematicsSystem(kinematics, vehicle.joints, vehicle.p_O),
        "weight_allocator": WeightAllocator(scenario.allocation, period),
        "equivalent_state": EquivalentState(model),
        "residual_estimator": make_residual_estimator(
            network_for(scenario, vehicle.joints),
            model,
            scenario.residual,
            scenario.faults,
            scenario.settle_s,
        ),
        scenario.controller: make_controller(scenario, model, vehicle),
        "setpoint_integrator": make_setpoint_integrator(scenario, vehicle),
        "supervisor": make_supervisor(scenario, vehicle),
    }
    if (pointing := make_pointing(scenario, vehicle)) is not None:
        systems["pointing"], wiring = pointing, wiring + POINTING_WIRING
    for name, system in systems.items():
        builder.AddNamedSystem(name, system)
    return wiring.rename("controller", scenario.controller).build(builder, "coordinator")


def make_controller(
    scenario: Scenario, model: EquivalentModel, vehicle: VehicleModel
) -> MpcSystem | ClikSystem:
    """Makes the scenario's controller; `KinematicController` describes how to add another."""
    if scenario.controller == "mpc":
        formulation = MpcFormulation(scenario.mpc, model, vehicle)
        with file_at(scenario.source, "mpc.solver"):
            return make_mpc(formulation, scenario.faults, scenario.settle_s)
    return ClikSystem(InverseKinematics(scenario.clik, scenario.mpc, model, vehicle))


def make_pointing(scenario: Scenario, vehicle: VehicleModel) -> PointingSystem | None:
    """Makes the system of the scenario's orientation task; None if it has none."""
    with file_at(scenario.source, "orientation.file"):
        direction = make_direction(scenario.orientation)
    if direction is None:
        return None
    stages_s = stage_times(scenario.mpc, scenario.rates.mpc_period_s)
    return PointingSystem(vehicle, direction, scenario.settle_s, stages_s)


def make_setpoint_integrator(scenario: Scenario, vehicle: VehicleModel) -> SetpointIntegrator:
    """Makes the setpoint integrator, which starts at the measured state."""
    return SetpointIntegrator(
        SetpointLimits.make(scenario.mpc, vehicle),
        SafeMotion.make(scenario.supervisor, vehicle),
        np.concatenate([vehicle.p_B, vehicle.working]),
        scenario.rates.mpc_period_s,
    )


def make_supervisor(scenario: Scenario, vehicle: VehicleModel) -> SupervisorSystem:
    """Makes the supervisor."""
    return SupervisorSystem(
        conditions(scenario.supervisor),
        vehicle,
        scenario.rates.sensor_period_s,
        scenario.rates.mpc_period_s,
    )
