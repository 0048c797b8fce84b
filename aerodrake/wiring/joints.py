"""Systems between the arm controller's torques and the links, if a scenario has any."""

from pydrake.systems.framework import DiagramBuilder

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.support.arguments import checked
from aerodrake.systems.faults.actuators import make_joint_faults
from aerodrake.systems.joint_friction import make_joint_friction
from aerodrake.systems.joint_motors import make_joint_motors
from aerodrake.systems.joint_transmission import make_joint_transmission
from aerodrake.wiring.table import Wiring

SYMBOLIC, MOTOR = ("u0", "y0"), ("motor_torque", "joint_torque")
"""Input and output port of the systems."""

JOINT_KEYS = ("coulomb_n_m", "viscous_n_m_s_rad", "backlash_rad", "flexibility_rad_n_m")
"""Keys of the section `actuation` with one value for all joints, or one for each."""


@checked
def add_joint_actuation(
    builder: DiagramBuilder, scenario: Scenario, vehicle: VehicleModel, wiring: Wiring
) -> Wiring:
    """Adds faults, motors, transmissions and friction of the joints, in this order.

    Args:
        builder: Builder of the station, with `arm_controller`, `physics` and `sensors`.
        scenario: Faults, mismatch and actuation.
        vehicle: The scenario's vehicle.
        wiring: Rows that connect `joint_torque` of `arm_controller`.

    Returns:
        These rows with the systems inserted.

    Raises:
        ScenarioError: if a list of values has the wrong length.
    """
    config, step = scenario.actuation, scenario.rates.plant_step_s
    for key in JOINT_KEYS:  # Also lists that add no system, such as empty ones.
        vehicle.per_joint(getattr(config, key), f"actuation.{key}")
    for name, system, ports in (  # From the links to the controller.
        ("joint_friction", make_joint_friction(config, vehicle, step), MOTOR),
        ("joint_transmission", make_joint_transmission(config, vehicle, step), MOTOR),
        ("joint_motors", make_joint_motors(scenario.mismatch, vehicle), SYMBOLIC),
        ("joint_faults", make_joint_faults(scenario, vehicle.joints), SYMBOLIC),
    ):
        if system is None:
            continue
        builder.AddNamedSystem(name, system)
        wiring = wiring.insert(name, ("arm_controller", "joint_torque"), *ports)
        rows = []
        if system.HasInputPort("true_state"):
            rows.append(("physics", "true_state", name, "true_state"))
        if system.HasOutputPort("encoder_state"):
            rows.append((name, "encoder_state", "sensors", "encoder_state"))
        wiring += Wiring(tuple(rows))
    return wiring
