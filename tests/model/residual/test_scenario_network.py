"""Network of a scenario, and the note on its plant."""

import dataclasses

import numpy as np
import pytest
import torch

from aerodrake.model.residual.checkpoint import Provenance, save
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.scenario_network import network_for, provenance_notes
from aerodrake.scenario import Flight, Model, Residual, Scenario
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.support.errors import BadInput

JOINTS = 6
PROVENANCE = Provenance("0.1.0", "trajectory", "m/s^2", "abc", "def")


def trained() -> ResidualNetwork:
    """Returns a network whose Delta is not zero."""
    network = ResidualNetwork.untrained(JOINTS, seed=4)
    with torch.no_grad():
        network.last.weight.fill_(0.1)
    return network


def test_a_scenario_without_checkpoint_has_an_untrained_network():
    scenario = Scenario(seed=3, residual=Residual(mode="online"))
    network, seeded = network_for(scenario, JOINTS), ResidualNetwork.untrained(JOINTS, 3)
    assert not network.last_layer().any()
    features = np.linspace(-1, 1, 30)
    np.testing.assert_array_equal(network.phi(features), seeded.phi(features))


@pytest.mark.parametrize("checkpoint", ["", "none.pt"])
def test_the_mode_off_has_no_network(checkpoint):
    assert network_for(Scenario(residual=Residual("off", checkpoint)), JOINTS) is None


def test_a_scenario_has_the_network_of_its_checkpoint(tmp_path):
    save(tmp_path / "a.pt", trained(), PROVENANCE)
    scenario = Scenario(residual=Residual("offline", str(tmp_path / "a.pt")))
    np.testing.assert_array_equal(
        network_for(scenario, JOINTS).last_layer(), trained().last_layer()
    )
    other = dataclasses.replace(
        scenario, flight=Flight(interface="position"), model=Model(kind="exact")
    )
    with pytest.raises(BadInput, match=r"residual\.checkpoint: .*position.*trajectory"):
        network_for(other, JOINTS)


@pytest.mark.parametrize(
    ("kind", "other", "quantity"),
    [("flight", "m/s", "residual acceleration"), ("paper", "m/s^2", "residual velocity")],
)
def test_a_network_for_another_residual_is_refused(tmp_path, kind, other, quantity):
    file = tmp_path / "a.pt"
    scenario = Scenario(residual=Residual("online", str(file)), model=Model(kind=kind))
    save(file, trained(), dataclasses.replace(PROVENANCE, delta_unit=other))
    with pytest.raises(BadInput) as error:
        network_for(scenario, JOINTS)
    for part in ("residual.checkpoint", quantity, f"model.kind {kind}", f"Delta is in {other}"):
        assert part in str(error.value)


def test_a_network_of_another_plant_is_noted(tmp_path):
    file = tmp_path / "a.pt"
    same = Scenario(residual=Residual("offline", str(file)))
    save(file, trained(), dataclasses.replace(PROVENANCE, plant_hash=plant_hash(same)))
    other = dataclasses.replace(same, model=Model(k_b=(2.0, 2.0, 2.0)))
    off = dataclasses.replace(other, residual=Residual("off", str(file)))
    none = dataclasses.replace(other, residual=Residual("online"))
    assert provenance_notes(same, JOINTS) == provenance_notes(off, JOINTS) == []
    assert provenance_notes(none, JOINTS) == []
    on = dataclasses.replace(other, residual=Residual("offline", str(file)))
    (note,) = provenance_notes(on, JOINTS)
    assert "another vehicle, flight controller or model" in note
