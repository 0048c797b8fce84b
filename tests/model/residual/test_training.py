import numpy as np
import pytest
import torch

from aerodrake.model.residual.training import Training, train

N = 6
QUICK = Training(epochs=8, batch=128)


def flight(seed, size=1.0, bias=0.0, samples=600):
    """Targets that are linear in velocity and in the base's commanded acceleration."""
    generator = np.random.default_rng(seed)
    features = generator.normal(size=(samples, 12 + 3 * N)) * 0.2
    features[:, 3:6] *= size
    features[:, 24:27] *= 5 * size
    targets = 0.2 * features[:, 3:6] - 0.05 * features[:, 24:27] + bias
    return features, targets


ONES = np.ones(3)


def trained(gain=ONES, seed=3, config=QUICK, **flights):
    training = flights.get("training", [flight(0), flight(1), flight(2)])
    return train(training, flights.get("validation", [flight(9)]), gain, N, seed, config)


def left(network, gain, features, targets):
    """Part of the RMS that is left."""
    delta = network.phi(features) @ network.last_layer().T
    return np.sqrt(((gain * delta - targets) ** 2).mean() / (targets**2).mean())


@pytest.fixture(scope="module")
def result():
    return trained(config=Training(epochs=25, batch=128))


def test_it_learns_what_carries_over(result):
    assert left(result.network, ONES, *flight(77)) < 0.25


def test_the_network_is_that_of_the_best_validation_loss(result):
    assert result.best_epoch == result.validation_loss.argmin()
    features, targets = flight(9)
    error = ((result.network.phi(features) @ result.network.last_layer().T - targets) ** 2).sum()
    assert error / (targets**2).sum() == pytest.approx(result.validation_loss.min(), rel=1e-6)


def test_what_is_learned_is_target_over_gain():
    gain = np.array([0.5, 1.0, 2.0])
    ours = trained(gain=gain, config=Training(epochs=25, batch=128)).network
    assert left(ours, gain, *flight(77)) < 0.3


def test_one_seed_gives_one_network_bit_for_bit_and_another_another():
    state = torch.random.get_rng_state()
    one, same, other = (trained(seed=seed).network.last_layer() for seed in (3, 3, 4))
    assert np.array_equal(one, same) and not np.array_equal(one, other)
    assert torch.equal(state, torch.random.get_rng_state())


def test_it_stops_when_validation_gets_no_better():
    config = Training(epochs=200, patience=3, batch=128)
    noise = np.random.default_rng(0).normal(size=(600, 3))
    result = trained(config=config, validation=[(flight(9)[0], noise)])
    assert len(result.validation_loss) == result.best_epoch + 4 < 200


def test_phi_is_large_enough_to_learn_fast_and_small_enough_to_learn_stably(result):
    power = (result.network.phi(flight(5)[0]) ** 2).sum(axis=1)
    assert power.min() > 50
    assert power.mean() < 1 / 0.0015  # 1 / eta: see `last_layer_step`.


def test_a_steady_tilt_hardly_moves_delta_where_an_ordinary_fit_would_follow_it():
    """Accelerations can be read out of attitude or setpoint; wind falsifies one of them."""

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

    plain = Training(epochs=15, batch=128, attitude_rad=0.0, rate_rad_s=0.0, acceleration_ratio=0.0)
    noisy = Training(epochs=15, batch=128, attitude_rad=0.2, rate_rad_s=0.0, acceleration_ratio=0.0)
    assert shift(noisy) < 0.7 * shift(plain)


def test_features_that_do_not_vary_are_harmless():
    flights = [flight(i) for i in range(3)]
    for features, _ in flights:
        features[:, 12] = 0.3
    network = trained(training=flights).network
    features, targets = flight(8)
    features[:, 12] = 0.3001
    assert left(network, ONES, features, targets) < 1.0
