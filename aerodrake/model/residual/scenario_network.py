"""The residual network that a scenario flies with.

Torch, which takes a second to import, is imported where there is one.
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
    """The network that a scenario names; an untrained one where it names none.

    None in the mode `off`, which needs none.

    Raises:
        ScenarioError: if the checkpoint cannot be used, or serves another flight interface.
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
    """What should be known of the network that a scenario flies with.

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
        "this scenario's; `aerodrake train` makes one for it"
    ]
