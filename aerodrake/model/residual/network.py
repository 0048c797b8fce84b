"""The network that estimates the residual Delta of the base, in the equivalent model's unit.

Two hidden layers of 32 units with ELU, as in the paper (section "Residual Learning").
Everything is float64, like the online update of the last layer, in which steps of 1e-9
still count. At this size float32 would be no faster.
"""

from dataclasses import dataclass, fields
from typing import Self

import numpy as np
import torch

from aerodrake.model.residual.features import HIDDEN, PHI_SIZE


@dataclass(frozen=True, eq=False)
class FeatureScaler:
    """Map (features - mean) / scale, fixed before a network is trained.

    Attributes:
        mean: (12 + 3 n,) in the features' units.
        scale: (12 + 3 n,) in the features' units, positive.
    """

    mean: np.ndarray
    scale: np.ndarray

    def __post_init__(self) -> None:
        for f in fields(self):
            frozen = np.array(getattr(self, f.name), dtype=np.float64)
            frozen.setflags(write=False)
            object.__setattr__(self, f.name, frozen)

    @classmethod
    def nominal(cls, joints: int) -> Self:
        """Returns the ranges expected in slow flight, for a network without training data."""
        # rad Theta_B, m/s v_B, rad/s omega_B, rad q, rad/s q', m/s^2 p_B,d'', rad/s^2 q_d''.
        sizes = (3, 3, 3, joints, joints, 3, joints)
        scale = np.repeat([0.1, 0.3, 0.3, 1.0, 0.5, 1.0, 3.0], sizes)
        return cls(np.zeros_like(scale), scale)


class ResidualNetwork(torch.nn.Module):
    """Delta = theta [ELU(W_2 ELU(W_1 s + b_1) + b_2); 1], with s the scaled features.

    The last layer starts at zero, so that Delta is exactly zero until the layer learns; the
    hidden layers start uniform in +-1/sqrt(inputs).

    Args:
        joints: n.
        scaler: Scaler of the 12 + 3 n features; it is not trained.
        seed: Seed of the hidden layers; torch's global generator is not used.
    """

    def __init__(self, joints: int, scaler: FeatureScaler, seed: int):
        super().__init__()
        self.joints = joints
        self.register_buffer("mean", torch.tensor(scaler.mean))
        self.register_buffer("scale", torch.tensor(scaler.scale))
        generator = torch.Generator().manual_seed(seed)
        first, second = HIDDEN
        hidden = _linear(len(scaler.mean), first, generator), _linear(first, second, generator)
        self.hidden = torch.nn.Sequential(hidden[0], torch.nn.ELU(), hidden[1], torch.nn.ELU())
        self.last = _linear(second, 3, generator)
        torch.nn.init.zeros_(self.last.weight)
        torch.nn.init.zeros_(self.last.bias)

    @classmethod
    def untrained(cls, joints: int, seed: int) -> Self:
        """Returns a network with the nominal scaler and a last layer of zeros."""
        return cls(joints, FeatureScaler.nominal(joints), seed)

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        """Returns Delta (..., 3) from unscaled features (..., 12 + 3 n)."""
        return self.last(self.activations(features))

    def activations(self, features: torch.Tensor) -> torch.Tensor:
        """Returns the last hidden activations (..., 32) from unscaled features (..., 12 + 3 n)."""
        return self.hidden((features - self.mean) / self.scale)

    def phi(self, features: np.ndarray) -> np.ndarray:
        """Returns (..., 33), activations and a 1, from unscaled features (..., 12 + 3 n)."""
        with torch.inference_mode():
            activations = self.activations(torch.from_numpy(features)).numpy()
        phi = np.ones((*activations.shape[:-1], PHI_SIZE))
        phi[..., :-1] = activations
        return phi

    def last_layer(self) -> np.ndarray:
        """Returns a (3, 33) copy of theta = [weights, bias] (paper: theta^l); Delta = theta phi."""
        with torch.no_grad():
            return torch.column_stack([self.last.weight, self.last.bias]).numpy()


def _linear(inputs: int, outputs: int, generator: torch.Generator) -> torch.nn.Linear:
    # skip_init, since torch's own initialisation draws from the global generator.
    layer = torch.nn.utils.skip_init(torch.nn.Linear, inputs, outputs, dtype=torch.float64)
    bound = inputs**-0.5
    torch.nn.init.uniform_(layer.weight, -bound, bound, generator=generator)
    torch.nn.init.uniform_(layer.bias, -bound, bound, generator=generator)
    return layer
