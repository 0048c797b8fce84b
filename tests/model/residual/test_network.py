"""Features and the network."""

import numpy as np
import pytest
import torch

from aerodrake.model.residual.features import feature_names, features
from aerodrake.model.residual.network import FeatureScaler, ResidualNetwork
from aerodrake.model.vehicle.state import VehicleState

JOINTS = 6


def trained(joints: int = JOINTS) -> ResidualNetwork:
    """Returns a network without zeros, with a random scaler."""
    rng = np.random.default_rng(3)
    size = len(feature_names(joints))
    scaler = FeatureScaler(rng.normal(size=size), rng.uniform(0.1, 2, size))
    network = ResidualNetwork(joints, scaler, seed=4)
    with torch.no_grad():
        network.last.weight.copy_(torch.tensor(rng.normal(size=(3, 32))))
        network.last.bias.copy_(torch.tensor(rng.normal(size=3)))
    return network


@pytest.mark.parametrize("joints", [1, 6, 7])
def test_features_are_in_the_order_of_their_names(joints):
    half = np.sqrt(0.5)  # A quarter turn of yaw: x of the base is y of the world.
    state = VehicleState(
        quaternion=np.array([half, 0, 0, half]),
        p_B=np.full(3, 99.0),
        q=np.arange(joints) + 10.0,
        omega_W=np.array([0.0, 0.3, 0.5]),
        v_B=np.array([1.0, 2.0, 3.0]),
        qdot=np.arange(joints) + 20.0,
    )
    u = np.arange(3 + joints) + 30.0
    named = dict(zip(feature_names(joints), features(state.to_vector(), u), strict=True))

    assert len(named) == 12 + 3 * joints
    assert named["roll_rad"] == pytest.approx(0)
    assert named["yaw_rad"] == pytest.approx(np.pi / 2)
    assert named["v_y_m_s"] == 2
    assert named["omega_x_rad_s"] == pytest.approx(0.3)
    assert named["omega_z_rad_s"] == pytest.approx(0.5)
    assert named["q_1_rad"] == 10
    assert named[f"qdot_{joints}_rad_s"] == 20 + joints - 1
    assert named["a_z_m_s2"] == 32
    assert named["qddot_1_rad_s2"] == 33


def test_untrained_delta_is_exactly_zero():
    network = ResidualNetwork.untrained(JOINTS, seed=0)
    inputs = np.random.default_rng(0).normal(size=(50, 30))
    assert torch.all(network(torch.tensor(inputs)) == 0)
    assert np.all(network.phi(inputs) @ network.last_layer().T == 0)


def test_only_the_seed_determines_the_network():
    before = torch.get_rng_state()
    a, b, c = (ResidualNetwork.untrained(JOINTS, seed) for seed in (1, 1, 2))
    assert torch.equal(before, torch.get_rng_state())
    inputs = np.ones(30)
    np.testing.assert_array_equal(a.phi(inputs), b.phi(inputs))
    assert np.any(a.phi(inputs) != c.phi(inputs))


@pytest.mark.parametrize("shape", [(30,), (15, 30)])
def test_phi_times_the_last_layer_equals_the_network(shape):
    network = trained()
    inputs = np.random.default_rng(0).normal(size=shape)
    phi = network.phi(inputs)
    assert phi.shape == (*shape[:-1], 33)
    assert np.all(phi[..., -1] == 1)
    np.testing.assert_allclose(
        phi @ network.last_layer().T,
        network(torch.tensor(inputs)).detach().numpy(),
        rtol=0,
        atol=1e-13,
    )


def test_hidden_layers_follow_the_paper():
    network, inputs = trained(), np.random.default_rng(0).normal(size=30)

    def elu(z):
        return np.where(z > 0, z, np.expm1(np.minimum(z, 0)))

    p = {name: tensor.numpy() for name, tensor in network.state_dict().items()}
    h = (inputs - p["mean"]) / p["scale"]
    h = elu(p["hidden.0.weight"] @ h + p["hidden.0.bias"])
    h = elu(p["hidden.2.weight"] @ h + p["hidden.2.bias"])
    np.testing.assert_allclose(network.phi(inputs), [*h, 1.0], rtol=0, atol=1e-13)


def test_last_layer_is_a_copy():
    network = trained()
    network.last_layer()[:] = 0
    assert np.all(network.last_layer() != 0)


def test_scaler_is_frozen():
    mean = np.zeros(30)
    scaler = FeatureScaler(mean, np.ones(30))
    mean[:] = 1
    assert np.all(scaler.mean == 0)
    with pytest.raises(ValueError, match="read-only"):
        scaler.scale[0] = 2
