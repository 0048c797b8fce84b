"""The closed form against autograd and torch's SGD."""

import numpy as np
import pytest
import torch

from aerodrake.model.residual.last_layer import last_layer_step
from aerodrake.model.residual.network import ResidualNetwork

# Threads that wait for each other cost a hundred times the arithmetic.
torch.set_num_threads(1)

JOINTS = 6


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("batch", [1, 7, 20])
def test_steps_equal_sgd_on_the_network(seed, batch):
    rng = np.random.default_rng(seed)
    network = ResidualNetwork.untrained(JOINTS, seed)
    with torch.no_grad():
        network.last.weight.copy_(torch.tensor(rng.normal(size=(3, 32))))
    gain, learning_rate = rng.uniform(0, 1, 3), 0.01
    sgd = torch.optim.SGD(network.last.parameters(), lr=learning_rate)
    theta = network.last_layer()

    for _ in range(10):
        features, base, measured = (rng.normal(size=(batch, m)) for m in (30, 3, 3))
        theta = last_layer_step(theta, network.phi(features), measured - base, gain, learning_rate)
        sgd.zero_grad()
        predicted = torch.tensor(base) + torch.tensor(gain) * network(torch.tensor(features))
        ((predicted - torch.tensor(measured)) ** 2).sum(dim=1).mean().backward()
        sgd.step()
        np.testing.assert_allclose(theta, network.last_layer(), rtol=0, atol=1e-12)


def test_the_argument_is_left_alone():
    theta = np.zeros((3, 4))
    moved = last_layer_step(theta, np.ones((2, 4)), np.ones((2, 3)), np.ones(3), 0.1)
    assert np.all(theta == 0) and np.all(moved == 0.2)


def test_no_gain_no_learning():
    theta = np.random.default_rng(0).normal(size=(3, 4))
    moved = last_layer_step(theta, np.ones((2, 4)), np.ones((2, 3)), np.zeros(3), 0.1)
    np.testing.assert_array_equal(moved, theta)


@pytest.mark.parametrize(("share", "shrinks"), [(0.99, True), (1.01, False)])
def test_documented_bound_of_stability(share, shrinks):
    rng = np.random.default_rng(1)
    phi, gain = rng.normal(size=(20, 5)), 0.9
    largest, axis = (v[..., -1] for v in np.linalg.eigh(phi.T @ phi / len(phi)))
    theta = np.tile(axis, (3, 1))
    moved = last_layer_step(
        theta, phi, np.zeros((20, 3)), np.full(3, gain), share / (gain**2 * largest)
    )
    assert (np.linalg.norm(moved) < np.linalg.norm(theta)) == shrinks
