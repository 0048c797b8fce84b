"""Residual network of a scenario.

Torch takes a second to import, and is imported only for scenarios with a network.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.support.errors import ScenarioError, file_at
from aerodrake.support.files import locate

if TYPE_CHECKING:
    from aerodrake.model.residual.network import ResidualNetwork


def network_for(scenario: Scenario, joints: int) -> ResidualNetwork | None:
    """Loads the scenario's checkpoint; without one, returns an untrained network.

    Returns None in the mode `off`.

    Raises:
        ScenarioError: if the checkpoint cannot be used, or is for another flight interface.
    """
    if scenario.residual.mode == "off":
        return None
    from aerodrake.model.residual.checkpoint import load
    from aerodrake.model.residual.network import ResidualNetwork

    file = scenario.residual.checkpoint
    if not file:
        return ResidualNetwork.untrained(joints, scenario.seed)
    with file_at(scenario.source, "residual.checkpoint"):
        network, provenance = load(locate(file), joints)
    if provenance.flight_interface != scenario.flight.interface:
        raise ScenarioError(
            scenario.source,
            "residual.checkpoint",
            f"expected a network for flight.interface {scenario.flight.interface}, got one for "
            f"{provenance.flight_interface}",
        )
    return network


def provenance_notes(scenario: Scenario, joints: int) -> list[str]:
    """Returns a note if the scenario's network was trained for another plant.

    Raises:
        ScenarioError: if the checkpoint cannot be used.
    """
    file = scenario.residual.checkpoint
    if not file or scenario.residual.mode == "off":
        return []
    from aerodrake.model.residual.checkpoint import load

    with file_at(scenario.source, "residual.checkpoint"):
        _, provenance = load(locate(file), joints)
    if provenance.plant_hash == plant_hash(scenario):
        return []
    return [
        "residual.checkpoint was trained for another vehicle, flight controller or model than "
        "this scenario's; `aerodrake train` trains a network for it"
    ]
