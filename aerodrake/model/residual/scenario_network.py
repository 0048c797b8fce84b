"""Residual network of a scenario. Torch is imported only if needed: that takes a second."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.scenario import Scenario
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.support.errors import ScenarioError, file_at
from aerodrake.support.files import locate

if TYPE_CHECKING:
    from aerodrake.model.residual.checkpoint import Provenance
    from aerodrake.model.residual.network import ResidualNetwork


def network_for(scenario: Scenario, joints: int) -> ResidualNetwork | None:
    """Returns the checkpoint's network, or an untrained one without; None in the mode `off`.

    Raises:
        ScenarioError: if the checkpoint cannot be used, or is for another flight interface or
            for a model with another residual.
    """
    if scenario.residual.mode == "off":
        return None
    if not scenario.residual.checkpoint:
        from aerodrake.model.residual.network import ResidualNetwork

        return ResidualNetwork.untrained(joints, scenario.seed)
    network, provenance = _load(scenario, joints)
    if provenance.flight_interface != scenario.flight.interface:
        raise ScenarioError(
            scenario.source,
            "residual.checkpoint",
            f"expected a network for flight.interface {scenario.flight.interface}, got one for "
            f"{provenance.flight_interface}",
        )
    residual = EquivalentModel.of(scenario, joints).residual
    if provenance.delta_unit != residual.unit:
        raise ScenarioError(
            scenario.source,
            "residual.checkpoint",
            f"expected a network for the {residual.name} of model.kind {scenario.model.kind} in "
            f"{residual.unit}, got one whose Delta is in {provenance.delta_unit}",
        )
    return network


def provenance_notes(scenario: Scenario, joints: int) -> list[str]:
    """Returns a note if the scenario's network was trained for another plant.

    Raises:
        ScenarioError: if the checkpoint cannot be used.
    """
    if not scenario.residual.checkpoint or scenario.residual.mode == "off":
        return []
    if _load(scenario, joints)[1].plant_hash == plant_hash(scenario):
        return []
    return [
        "residual.checkpoint was trained for another vehicle, flight controller or model than "
        "this scenario's; `aerodrake train` trains a network for it"
    ]


def _load(scenario: Scenario, joints: int) -> tuple[ResidualNetwork, Provenance]:
    from aerodrake.model.residual.checkpoint import load

    with file_at(scenario.source, "residual.checkpoint"):
        return load(locate(scenario.residual.checkpoint), joints)
