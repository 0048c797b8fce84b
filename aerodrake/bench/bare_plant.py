"""The physics alone: what a closed loop is compared with in cost."""

from __future__ import annotations

from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.wiring.physics import add_physics


def make_bare_plant(scenario: Scenario) -> Diagram:
    """The station's plant, scene graph, propellers and rotors, at the constant input of trim.

    Nothing in it is Python, and nothing holds the vehicle: it drifts off slowly, as
    rounding has it. Outputs: `true_state` (13 + 2 n).
    """
    vehicle = VehicleModel.load(scenario)
    builder = DiagramBuilder()
    physics = add_physics(builder, scenario, vehicle)
    thrust_command = builder.AddNamedSystem(
        "thrust_command", ConstantVectorSource(physics.trim_thrust)
    )
    joint_torque = builder.AddNamedSystem("joint_torque", ConstantVectorSource(vehicle.trim_torque))
    builder.Connect(thrust_command.get_output_port(), physics.rotors.get_input_port())
    builder.Connect(joint_torque.get_output_port(), physics.plant.get_actuation_input_port())
    builder.ExportOutput(physics.plant.get_state_output_port(), "true_state")
    diagram = builder.Build()
    diagram.set_name("bare_plant")
    return diagram
