"""Training of the network on synthetic flights."""

import numpy as np
import pytest
import torch

from aerodrake.model.residual.training import TrainingConfig, TrainingData, train

N = 6
QUICK = TrainingConfig(epochs=8, batch=128)


def flight(seed, size=1.0, bias=0.0, samples=600):
    """Returns a flight with targets linear in velocity and the base's commanded acceleration."""
    generator = np.random.default_rng(seed)
    features = generator.normal(size=(samples, 12 + 3 * N)) * 0.2
    features[:, 3:6] *= size
    features[:, 24:27] *= 5 * size
    targets = 0.2 * features[:, 3:6] - 0.05 * features[:, 24:27] + bias
    return features, targets


ONES = np.ones(3)


def trained(gain=ONES, seed=3, config=QUICK, **flights):
    training = flights.get("training", [flight(0), flight(1), flight(2)])
    data = TrainingData(training, flights.get("validation", [flight(9)]), gain, N)
    return train(data, seed, config)


def relative_error(network, gain, features, targets):
    """Returns the RMS error relative to the RMS target."""
    delta = network.phi(features) @ network.last_layer().T
    return np.sqrt(((gain * delta - targets) ** 2).mean() / (targets**2).mean())


@pytest.fixture(scope="module")
def result():
    return trained(config=TrainingConfig(epochs=25, batch=128))


def test_the_network_generalises(result):
    assert relative_error(result.network, ONES, *flight(77)) < 0.25


def test_the_network_has_the_lowest_validation_loss(result):
    assert result.best_epoch == result.validation_loss.argmin()
    features, targets = flight(9)
    error = ((result.network.phi(features) @ result.network.last_layer().T - targets) ** 2).sum()
    assert error / (targets**2).sum() == pytest.approx(result.validation_loss.min(), rel=1e-6)


def test_the_unit_of_delta_does_not_change_the_training():
    """Nor its losses: a gain of a power of two is exact."""
    plain, scaled = trained(), trained(gain=np.full(3, 2.0**-6))
    np.testing.assert_array_equal(scaled.network.last_layer(), 64 * plain.network.last_layer())
    np.testing.assert_array_equal(scaled.validation_loss, plain.validation_loss)


def test_delta_is_target_over_gain():
    gain = np.array([0.5, 1.0, 2.0])
    network = trained(gain=gain, config=TrainingConfig(epochs=25, batch=128)).network
    assert relative_error(network, gain, *flight(77)) < 0.3


def test_the_seed_determines_the_network_bit_for_bit():
    state = torch.random.get_rng_state()
    one, same, other = (trained(seed=seed).network.last_layer() for seed in (3, 3, 4))
    assert np.array_equal(one, same) and not np.array_equal(one, other)
    assert torch.equal(state, torch.random.get_rng_state())


def test_training_stops_when_the_validation_loss_no_longer_falls():
    config = TrainingConfig(epochs=200, patience=3, batch=128)
    noise = np.random.default_rng(0).normal(size=(600, 3))
    result = trained(config=config, validation=[(flight(9)[0], noise)])
    assert len(result.validation_loss) == result.best_epoch + 4 < 200


def test_phi_allows_fast_and_stable_online_learning(result):
    power = (result.network.phi(flight(5)[0]) ** 2).sum(axis=1)
    assert power.min() > 50
    assert power.mean() < 1 / 0.0015  # 1 / eta: see `last_layer_step`.


def test_noise_on_the_attitude_reduces_the_effect_of_a_steady_tilt():
    """Attitude and setpoint both contain the acceleration; wind biases the attitude."""

    def tilted(seed):
        features, targets = flight(seed)
        features[:, 0] = -features[:, 25] / 9.81
        features[:, 1] = features[:, 24] / 9.81
        return features, targets

    flights = {"training": [tilted(i) for i in range(3)], "validation": [tilted(9)]}

    def shift(config):
        network = trained(config=config, **flights).network
        features, _ = tilted(5)
        moved = features.copy()
        moved[:, 1] += 0.035
        delta = (network.phi(moved) - network.phi(features)) @ network.last_layer().T
        return abs(delta[:, 0].mean())

    plain = TrainingConfig(
        epochs=15, batch=128, attitude_rad=0.0, rate_rad_s=0.0, acceleration_ratio=0.0
    )
    noisy = TrainingConfig(
        epochs=15, batch=128, attitude_rad=0.2, rate_rad_s=0.0, acceleration_ratio=0.0
    )
    assert shift(noisy) < 0.7 * shift(plain)


def test_constant_features_are_harmless():
    flights = [flight(i) for i in range(3)]
    for features, _ in flights:
        features[:, 12] = 0.3
    network = trained(training=flights).network
    features, targets = flight(8)
    features[:, 12] = 0.3001
    assert relative_error(network, ONES, features, targets) < 1.0
