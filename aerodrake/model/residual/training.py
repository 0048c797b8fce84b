"""Offline training of the residual network."""

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import torch

from aerodrake.model.residual.network import FeatureScaler, ResidualNetwork
from aerodrake.model.residual.samples import Samples

RMS_FLOOR = 1e-3
"""m/s, smallest RMS residual by which the weight of a flight is normalised."""

WEIGHT_GAIN = 2.5
"""Factor on the initial weights of the hidden layers (see `train`)."""

BIAS = 2.6
"""Initial bias added to the second hidden layer (see `train`)."""


@dataclass(frozen=True)
class TrainingConfig:
    """Settings of the optimiser, and noise on the features.

    Attributes:
        learning_rate: Initial learning rate of Adam; it falls to zero along half a cosine.
        epochs: Maximum number of passes through the training samples.
        patience: Number of epochs without a lower validation loss after which training stops.
        batch: Number of samples in a step.
        attitude_rad: Standard deviation of the noise on roll and pitch.
        rate_rad_s: Standard deviation of the noise on the roll and pitch rates.
        acceleration_ratio: Standard deviation of the noise on the base's commanded
            acceleration, relative to that acceleration's RMS in the same flight.
    """

    learning_rate: float = 0.01
    epochs: int = 60
    patience: int = 20
    batch: int = 1024
    attitude_rad: float = 0.03
    rate_rad_s: float = 0.1
    acceleration_ratio: float = 0.4


@dataclass(frozen=True, eq=False)
class TrainingResult:
    """Trained network, and losses relative to the targets' mean square.

    Attributes:
        network: Network with the lowest validation loss.
        training_loss: (epochs,) mean over the epoch, with noise on the features.
        validation_loss: (epochs,) loss on the validation flights, without noise.
        best_epoch: Epoch of the network, from 0.
    """

    network: ResidualNetwork
    training_loss: np.ndarray
    validation_loss: np.ndarray
    best_epoch: int


class TrainingData(NamedTuple):
    """Samples of a vehicle's flights.

    Attributes:
        training: Flights whose samples the network is fitted to.
        validation: Other flights, by which the epoch is selected.
        gain: (3,) c, positive, `EquivalentModel.residual_gain`.
        joints: n.
    """

    training: Sequence[Samples]
    validation: Sequence[Samples]
    gain: np.ndarray
    joints: int


def train(
    data: TrainingData,
    seed: int,
    config: TrainingConfig,
    progress: Callable[[float, float], None] = lambda training, validation: None,
) -> TrainingResult:
    """Trains a network to fit Delta = target / gain, in the model's unit.

    The loss is the mean over flights of the squared error of c Delta relative to the flight's own
    mean squared target, so that slow and fast flights have equal weights.

    Noise on roll, pitch and their rates keeps the network from inferring accelerations from the
    attitude: in wind the base tilts without accelerating. The network then infers them from the
    setpoint and the velocity. Noise on the commanded acceleration bounds the dependence of Delta
    on u: the MPC chooses u by Delta, and a strong dependence makes the two oscillate.

    Online learning corrects Delta by a fraction 2 eta |phi|^2 of its error at every tick:
    with the small phi of an ordinary initialisation a constant error takes seconds to learn. The
    hidden layers therefore start with larger weights and biases; training on phi minus its mean
    preserves them.

    Args:
        data: Training and validation flights.
        seed: Seed of the hidden layers, the order of the samples and the noise.
        config: Settings.
        progress: Called after each epoch with its two losses.
    """
    joints = data.joints
    features, targets, weights = _stack(data.training)
    validation_features, *validation = _stack(data.validation)
    scale = np.maximum(features.std(dim=0).numpy(), FeatureScaler.nominal(joints).scale)
    network = ResidualNetwork(joints, FeatureScaler(features.mean(dim=0).numpy(), scale), seed)
    model = _Centred(network, features, float((targets**2).mean().sqrt()))
    noise = torch.from_numpy(np.vstack([_noise(f, joints, config) for f, _ in data.training]))

    steps = math.ceil(len(features) / config.batch)
    optimizer = torch.optim.Adam(network.parameters(), lr=config.learning_rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, config.epochs * steps)
    generator = torch.Generator().manual_seed(seed)
    losses: list[tuple[float, float]] = []
    best = 0, math.inf, copy.deepcopy(network.state_dict())
    for epoch in range(config.epochs):
        total = 0.0
        for rows in torch.randperm(len(features), generator=generator).split(config.batch):
            drawn = torch.randn(noise[rows].shape, generator=generator, dtype=torch.float64)
            noisy = features[rows] + noise[rows] * drawn
            loss = _loss(model(noisy), targets[rows], weights[rows])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += len(rows) * loss.item()
        with torch.inference_mode():
            validation_loss = _loss(model(validation_features), *validation).item()
        losses.append((total / len(features), validation_loss))
        progress(*losses[-1])
        if validation_loss < best[1]:
            best = epoch, validation_loss, copy.deepcopy(network.state_dict())
        if epoch - best[0] >= config.patience:
            break
    network.load_state_dict(best[2])
    model.fold(data.gain)
    return TrainingResult(network, *np.array(losses).T, best[0])


def _stack(flights: Sequence[Samples]) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Returns features, targets and weights (T, 1) of all flights.

    The weighted mean square of each flight's targets is 1, unless it is below `RMS_FLOOR`.
    """
    squares = [(targets**2).sum(axis=1) for _, targets in flights]
    weights = [np.full((len(s), 1), 1 / max(s.mean(), RMS_FLOOR**2)) for s in squares]
    features, targets, weight = map(np.vstack, (*zip(*flights, strict=True), weights))
    features, targets, weight = map(torch.from_numpy, (features, targets, weight))
    return features, targets, weight


def _noise(features: np.ndarray, joints: int, config: TrainingConfig) -> np.ndarray:
    """Returns (T, 12 + 3 n), standard deviations of the noise on one flight's features."""
    noise = np.zeros_like(features)
    acceleration = slice(-3 - joints, -joints)  # Columns as in `feature_names`.
    noise[:, :2], noise[:, 6:8] = config.attitude_rad, config.rate_rad_s
    rms = np.sqrt((features[:, acceleration] ** 2).mean())
    noise[:, acceleration] = config.acceleration_ratio * rms
    return noise


def _loss(predicted: torch.Tensor, target: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    return (weight * (predicted - target) ** 2).sum(dim=1).mean()


class _Centred:
    """Network in training, which outputs c Delta in m/s.

    The last layer receives phi minus its mean, and is scaled: steps along the mean of phi and
    along its variation then are equally well conditioned.
    """

    def __init__(self, network: ResidualNetwork, features: torch.Tensor, rms: float):
        self._network = network
        first, second = network.hidden[0], network.hidden[2]
        with torch.no_grad():
            first.weight *= WEIGHT_GAIN
            second.weight *= WEIGHT_GAIN
            second.bias += BIAS
            phi = network.activations(features)
            self._centre = phi.mean(dim=0)
            self._scale = rms / float(((phi - self._centre) ** 2).sum(dim=1).mean().sqrt())

    def __call__(self, features: torch.Tensor) -> torch.Tensor:
        phi = self._network.activations(features)
        return self._scale * self._network.last(phi - self._centre)

    def fold(self, gain: np.ndarray) -> None:
        """Converts the last layer to the plain network's, which outputs Delta; gain (3,) is c."""
        last = self._network.last
        with torch.no_grad():
            last.weight *= self._scale
            last.bias *= self._scale
            last.bias -= last.weight @ self._centre
            last.weight /= torch.tensor(gain)[:, None]
            last.bias /= torch.tensor(gain)
