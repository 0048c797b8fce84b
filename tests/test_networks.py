"""Packaged networks, on flights that neither fitted nor selected them."""

import dataclasses

import numpy as np
import pytest

from aerodrake.learning.collection_runs import CollectionRun, circle, fly_run, with_disturbances
from aerodrake.learning.evaluation import Candidates, evaluate
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.residual.checkpoint import load
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.model.residual.samples import residual_samples
from aerodrake.model.residual.scenario_network import provenance_notes
from aerodrake.scenario.fingerprint import plant_hash
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.support.files import locate

JOINTS = 6
RUNS = [
    *with_disturbances(
        CollectionRun("a", "held_out", 9.0, 7.0, -0.9, circle(0.12, 0.15, -0.8)), 1.0, 77
    ),
    *with_disturbances(CollectionRun("b", "held_out", 9.0, 9.0, 0.8), -2.0, 78),
]
PACKAGED = {
    name: scenario
    for name in packaged_scenarios()
    if (scenario := load_scenario(name)).residual.checkpoint
}


@pytest.fixture(scope="module")
def flown():
    """Returns the samples of the runs, the network, and its learner."""
    scenario = load_scenario("clover_paper")
    network, _ = load(locate(scenario.residual.checkpoint), JOINTS)
    model = EquivalentModel.of(scenario, JOINTS)
    flights = {run.name: residual_samples(model, fly_run(scenario, run)) for run in RUNS}
    theta = model.residual_gain[:, None] * network.last_layer()
    return flights, network, OnlineLearner(scenario.residual, theta)


@pytest.fixture(scope="module")
def evaluation(flown):
    flights, network, learner = flown
    fit = LinearResidual.fit([flights["a"]], 0.0)
    return evaluate(RUNS, flights, Candidates(network, learner, fit, fit))


def test_the_papers_scenarios_have_networks_trained_for_them():
    assert {"clover_paper", "moving_target_paper"} <= PACKAGED.keys()
    for scenario in PACKAGED.values():
        assert provenance_notes(dataclasses.replace(scenario), JOINTS) == []


def test_networks_are_small_and_have_their_provenance():
    for scenario in PACKAGED.values():
        path = locate(scenario.residual.checkpoint)
        assert path.stat().st_size < 100_000
        _, provenance = load(path, JOINTS)
        assert provenance.flight_interface == scenario.flight.interface
        assert provenance.delta_unit == EquivalentModel.of(scenario, JOINTS).residual.unit
        assert provenance.plant_hash == plant_hash(scenario)


def test_the_network_removes_most_of_the_residual_in_calm_air(evaluation):
    assert evaluation.removed >= 0.6


def test_the_network_is_never_much_worse_than_none(evaluation):
    assert evaluation.worst <= 1.1


def test_learning_online_recovers_half_of_what_wind_and_payload_add(evaluation):
    assert evaluation.least_recovered >= 0.5
    assert evaluation.recovered(1) is not None  # The gusts add more than `MIN_ADDED`.


def test_online_steps_are_stable(flown):
    """See `last_layer_step`: eta lambda < 1 for the largest eigenvalue of mean phi phi^T."""
    flights, network, learner = flown
    batch = learner.config.batch
    for features, _ in flights.values():
        phi = network.phi(features)
        batches = phi[: len(phi) // batch * batch].reshape(-1, batch, phi.shape[1])
        gram = np.einsum("bti,btj->bij", batches, batches) / batch
        largest = np.linalg.eigvalsh(gram)[:, -1].max()
        assert learner.config.learning_rate * largest < 1
