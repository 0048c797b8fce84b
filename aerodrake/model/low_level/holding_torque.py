"""Joint torques that hold the arm and its payload in hover, and notes on those near limits."""

import numpy as np

from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.vehicle import GRAVITY, VehicleModel
from aerodrake.scenario import Scenario

LARGE_SHARE = 0.8
"""Share of a torque limit beyond which a flight is likely to reach it."""


def holding_torque(scenario: Scenario, vehicle: VehicleModel) -> np.ndarray:
    """Returns the joint torques (n,) N m in hover in the working configuration.

    They include the payload and the mismatch of the mass, which the controllers do not know.
    """
    _, J_B = Kinematics(vehicle.plant).arm(vehicle.working)
    weight = scenario.payload.mass_kg * GRAVITY
    return scenario.mismatch.mass_scale * vehicle.trim_torque + weight * J_B[2]


def torque_notes(scenario: Scenario, vehicle: VehicleModel) -> list[str]:
    """Returns a note for each joint whose torque in hover exceeds or nearly reaches its limit."""
    torque = np.abs(holding_torque(scenario, vehicle))
    causes = ["the arm"]
    if scenario.payload.mass_kg > 0:
        causes.append(f"payload.mass_kg ({scenario.payload.mass_kg:g} kg)")
    notes = []
    for name, needed, limit in zip(vehicle.joint_names, torque, vehicle.effort, strict=True):
        if needed >= LARGE_SHARE * limit:
            effect = "it falls" if needed >= limit else "little is left to move it"
            notes.append(
                f"{name} needs {needed:.3g} N m of its {limit:.3g} N m to hold "
                f"{' and '.join(causes)} in hover: {effect}"
            )
    return notes
