"""Notes on a scenario before its flight."""

from aerodrake.model.low_level.holding_torque import torque_notes
from aerodrake.model.low_level.thrust_allocation import thrust_notes
from aerodrake.model.reference.envelope_notes import envelope_notes
from aerodrake.model.residual.scenario_network import provenance_notes
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.notes import value_notes


def scenario_notes(scenario: Scenario) -> list[str]:
    """Returns notes on values that are valid but may degrade the flight.

    Raises:
        BadInput: if a file that the scenario names cannot be used.
    """
    vehicle = VehicleModel.load(scenario)
    vehicle_notes = [
        *thrust_notes(scenario, vehicle),
        *torque_notes(scenario, vehicle),
        *envelope_notes(scenario, vehicle),
    ]
    return [*value_notes(scenario), *provenance_notes(scenario, vehicle.joints), *vehicle_notes]
