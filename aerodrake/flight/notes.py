"""Notes on a scenario before its flight."""

from aerodrake.model.low_level.thrust_allocation import thrust_notes
from aerodrake.model.reference.envelope_notes import envelope_notes
from aerodrake.model.residual.scenario_network import provenance_notes
from aerodrake.scenario import Scenario
from aerodrake.scenario.warnings import warnings


def scenario_notes(scenario: Scenario) -> list[str]:
    """Returns notes on values that are valid but may degrade the flight.

    Raises:
        BadInput: if a file that the scenario names cannot be used.
    """
    joints = len(scenario.vehicle.working_rad)
    vehicle_notes = [*thrust_notes(scenario), *envelope_notes(scenario)]
    return [*warnings(scenario), *provenance_notes(scenario, joints), *vehicle_notes]
