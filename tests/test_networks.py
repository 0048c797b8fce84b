"""The networks that ship, on flights that no training and no choice has seen."""

import dataclasses

import numpy as np
import pytest

from aerodrake.learning.evaluation import evaluate
from aerodrake.learning.stages import Stage, circle, fly_stage, weathers
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.checkpoint import load
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.samples import residual_samples
from aerodrake.model.residual.scenario_network import provenance_notes
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.support.files import locate

JOINTS = 6
FLIGHTS = [
    *weathers(Stage("a", "held_out", 16.0, 7.0, -0.9, circle(0.12, 0.15, -0.8)), 1.0, 77),
    *weathers(Stage("b", "held_out", 16.0, 9.0, 0.8), -2.0, 78),
]
SHIPPED = {
    name: scenario
    for name in packaged_scenarios()
    if (scenario := load_scenario(name)).residual.checkpoint
}


@pytest.fixture(scope="module")
def flown():
    """The flights' samples, the network, the model's gain and the residual section."""
    scenario = load_scenario("clover_paper")
    network, _ = load(locate(scenario.residual.checkpoint), JOINTS)
    model = EquivalentModel.of(scenario, JOINTS)
    flights = {}
    for stage in FLIGHTS:
        tape = fly_stage(scenario, stage)
        flights[stage.name] = residual_samples(
            model,
            tape.state,
            tape.base_setpoint,
            tape.joint_setpoint,
            tape.specific_thrust,
            tape.external_acceleration,
            tape.disturbance,
        )
    gain = model.C[model.base_velocity].diagonal()
    return flights, network, gain, scenario.residual


@pytest.fixture(scope="module")
def evaluation(flown):
    fit = LinearResidual.fit([flown[0]["a"]], 0.0)
    return evaluate(FLIGHTS, *flown, fit, fit)


def test_the_papers_scenarios_fly_with_a_network_made_for_them():
    assert {"clover_paper", "moving_target_paper"} <= SHIPPED.keys()
    for scenario in SHIPPED.values():
        assert provenance_notes(dataclasses.replace(scenario), JOINTS) == []


def test_networks_are_small_and_say_where_they_come_from():
    for scenario in SHIPPED.values():
        path = locate(scenario.residual.checkpoint)
        assert path.stat().st_size < 100_000
        _, provenance = load(path, JOINTS)
        assert provenance.flight_interface == scenario.flight.interface
        assert provenance.plant_hash == plant_hash(scenario)


def test_it_removes_most_of_the_residual_in_calm_air(evaluation):
    assert evaluation.removed >= 0.6


def test_it_is_nowhere_worse_than_no_network(evaluation):
    assert evaluation.worst <= 1.1


def test_learning_online_recovers_half_of_what_wind_and_payload_add(evaluation):
    assert evaluation.least_recovered >= 0.5
    assert evaluation.recovered(1) is not None  # The gusts add a good deal.


def test_online_steps_are_stable(flown):
    """See `last_layer_step`: eta c^2 lambda < 1 for the largest eigenvalue of mean phi phi^T."""
    flights, network, gain, residual = flown
    for features, _ in flights.values():
        phi = network.phi(features)
        batches = phi[: len(phi) // residual.batch * residual.batch]
        batches = batches.reshape(-1, residual.batch, phi.shape[1])
        gram = np.einsum("bti,btj->bij", batches, batches) / residual.batch
        largest = np.linalg.eigvalsh(gram)[:, -1].max()
        assert residual.learning_rate * (gain**2).max() * largest < 1
