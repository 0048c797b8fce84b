"""The hidden layers of the residual network, as they are inferred in flight."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from aerodrake.compiled import compiled


class HiddenLayers(NamedTuple):
    """Frozen: what is learned in flight is the layer after them.

    Attributes:
        mean, scale: (m,) of the features, in their units.
        W_1, b_1: (h, m) and (h,) of the first layer, of scaled features.
        W_2, b_2: (h, h) and (h,) of the second.
    """

    mean: np.ndarray
    scale: np.ndarray
    W_1: np.ndarray
    b_1: np.ndarray
    W_2: np.ndarray
    b_2: np.ndarray

    @classmethod
    def none(cls, size: int) -> HiddenLayers:
        """Without a unit, for `size` features: phi is the 1 that a bias multiplies."""
        empty = np.zeros(0)
        return cls(
            np.zeros(size), np.ones(size), np.zeros((0, size)), empty, np.zeros((0, 0)), empty
        )


@compiled
def infer_phi(layers: HiddenLayers, features: np.ndarray) -> np.ndarray:
    """(h + 1,) last hidden activations and a 1, from unscaled features (m,)."""
    phi = np.ones(len(layers.b_2) + 1)
    if len(phi) > 1:
        scaled = (features - layers.mean) / layers.scale
        phi[:-1] = _elu(layers.W_2 @ _elu(layers.W_1 @ scaled + layers.b_1) + layers.b_2)
    return phi


@compiled
def _elu(z: np.ndarray) -> np.ndarray:
    return np.where(z > 0, z, np.expm1(np.minimum(z, 0.0)))
