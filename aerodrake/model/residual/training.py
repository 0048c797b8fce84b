"""Offline training of the residual network."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import torch

from aerodrake.model.residual.network import FeatureScaler, ResidualNetwork
from aerodrake.model.residual.samples import Samples

RMS_FLOOR = 1e-3
"""m/s: flights whose residual is smaller than this count as if it were this large."""

WEIGHT_GAIN = 2.5
"""Of the hidden layers' weights at the start of training (see `train`)."""

BIAS = 2.6
"""Of the second hidden layer's units at the start of training (see `train`)."""


@dataclass(frozen=True)
class Training:
    """How a network is trained.

    Attributes:
        learning_rate: Of Adam at first; it falls to zero along half a cosine.
        epochs: The most passes through the training samples.
        patience: Epochs without a better validation loss after which it stops.
        batch: Samples in a step.
        attitude_rad: Deviation of the noise on roll and pitch.
        rate_rad_s: Deviation of the noise on the roll and pitch rates.
        acceleration_ratio: Deviation of the noise on the base's commanded acceleration,
            over that acceleration's RMS in the same flight.
    """

    learning_rate: float = 0.01
    epochs: int = 60
    patience: int = 20
    batch: int = 1024
    attitude_rad: float = 0.03
    rate_rad_s: float = 0.1
    acceleration_ratio: float = 0.4


@dataclass(frozen=True, eq=False)
class Trained:
    """What came of it.

    Attributes:
        network: With the lowest validation loss.
        training_loss: (epochs,) part of the targets' mean square that is left, over
            the epoch, noise on the features included.
        validation_loss: (epochs,) the same of the validation flights, without noise.
        best_epoch: Whose network it is, from 0.
    """

    network: ResidualNetwork
    training_loss: np.ndarray
    validation_loss: np.ndarray
    best_epoch: int


def train(
    flights: Sequence[Samples],
    validation: Sequence[Samples],
    gain: np.ndarray,
    joints: int,
    seed: int,
    config: Training,
    progress: Callable[[float, float], None] = lambda training, validation: None,
) -> Trained:
    """Fits Delta = target / gain.

    The loss is the mean over flights of the squared error over the flight's own
    mean squared target: a gentle flight counts as much as a wild one.

    Noise on roll, pitch and their rates keeps the network from reading
    accelerations out of the attitude, which wind tilts without any
    acceleration; so they are inferred from the setpoint and the velocity. Noise on
    the commanded acceleration bounds how much Delta follows u: the MPC chooses u by
    Delta, and the loop of the two chatters when it follows closely.

    Online learning corrects Delta by a fraction 2 eta c^2 |phi|^2 of its error at
    every tick: with the small phi of an ordinary initialisation a constant error
    takes seconds to learn. The hidden layers therefore start with larger weights
    and biases, and training, which is shown phi about its mean, keeps them there.

    Args:
        flights: To train on.
        validation: To choose the epoch by; other flights.
        gain: (3,) c, the diagonal of the model's C in the rows of p_B'.
        joints: n.
        seed: Of the hidden layers, the order of the samples and the noise.
        config: How.
        progress: Called after each epoch with its two losses.
    """
    features, targets, weights = _stack(flights, gain)
    judged = _stack(validation, gain)
    scale = np.maximum(features.std(dim=0).numpy(), FeatureScaler.nominal(joints).scale)
    network = ResidualNetwork(joints, FeatureScaler(features.mean(dim=0).numpy(), scale), seed)
    model = _Centred(network, features, float((targets**2).mean().sqrt()))
    noise = torch.from_numpy(np.vstack([_noise(f, joints, config) for f, _ in flights]))

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
            seen = features[rows] + noise[rows] * drawn
            loss = _loss(model(seen), targets[rows], weights[rows])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += len(rows) * loss.item()
        with torch.inference_mode():
            judgement = _loss(model(judged[0]), *judged[1:]).item()
        losses.append((total / len(features), judgement))
        progress(*losses[-1])
        if judgement < best[1]:
            best = epoch, judgement, copy.deepcopy(network.state_dict())
        if epoch - best[0] >= config.patience:
            break
    network.load_state_dict(best[2])
    model.fold()
    training_loss, validation_loss = np.array(losses).T
    return Trained(network, training_loss, validation_loss, best[0])


def _stack(
    flights: Sequence[Samples], gain: np.ndarray
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Features, Delta and weights (T, 1) of all flights; the weights' mean square Delta is 1."""
    weights = []
    for _, targets in flights:
        mean_square = (targets**2).sum(axis=1).mean()
        weights.append(np.full((len(targets), 1), 1 / max(mean_square, RMS_FLOOR**2)))
    features, targets = (np.vstack(parts) for parts in zip(*flights, strict=True))
    return (
        torch.from_numpy(features),
        torch.from_numpy(targets / gain),
        torch.from_numpy(np.vstack(weights)),
    )


def _noise(features: np.ndarray, joints: int, config: Training) -> np.ndarray:
    """(T, 12 + 3 n) deviations of the noise on one flight's features."""
    noise = np.zeros_like(features)
    acceleration = slice(-3 - joints, -joints)  # Places as in `feature_names`.
    noise[:, :2], noise[:, 6:8] = config.attitude_rad, config.rate_rad_s
    rms = np.sqrt((features[:, acceleration] ** 2).mean())
    noise[:, acceleration] = config.acceleration_ratio * rms
    return noise


def _loss(delta: torch.Tensor, target: torch.Tensor, weight: torch.Tensor) -> torch.Tensor:
    return (weight * (delta - target) ** 2).sum(dim=1).mean()


class _Centred:
    """The network while it is trained: its last layer sees phi about its mean, and scaled.

    That makes steps in phi's common part and in its variation equally easy,
    however large either is. `fold` turns it into the plain network it stands for.
    """

    def __init__(self, network: ResidualNetwork, features: torch.Tensor, rms: float):
        self._network = network
        first, second = network.hidden[0], network.hidden[2]
        with torch.no_grad():
            first.weight *= WEIGHT_GAIN
            second.weight *= WEIGHT_GAIN
            second.bias += BIAS
            phi = self._phi(features)
            self._centre = phi.mean(dim=0)
            self._scale = rms / float(((phi - self._centre) ** 2).sum(dim=1).mean().sqrt())

    def __call__(self, features: torch.Tensor) -> torch.Tensor:
        return self._scale * self._network.last(self._phi(features) - self._centre)

    def fold(self) -> None:
        last = self._network.last
        with torch.no_grad():
            last.weight *= self._scale
            last.bias *= self._scale
            last.bias -= last.weight @ self._centre

    def _phi(self, features: torch.Tensor) -> torch.Tensor:
        network = self._network
        return network.hidden((features - network.mean) / network.scale)
