"""Linear models of the velocity correction c Delta, as baselines for the network."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from aerodrake.model.residual.samples import Samples

ALPHAS = tuple(10.0 ** np.arange(-6, 2))
"""Candidate ridge penalties, for standardised features."""


@dataclass(frozen=True, eq=False)
class LinearResidual:
    """Model target = coefficients [(features - mean) / scale; 1].

    Attributes:
        mean, scale: (m,) mean and standard deviation of the features.
        coefficients: (3, m + 1) m/s, the intercept last.
        alpha: Ridge penalty of the fit.
    """

    mean: np.ndarray
    scale: np.ndarray
    coefficients: np.ndarray
    alpha: float

    @classmethod
    def fit(cls, flights: Sequence[Samples], alpha: float) -> Self:
        """Minimises mean squared error + alpha |coefficients|^2, without penalty on the intercept.

        All samples have equal weights. Without penalty, constant features have coefficients 0.
        """
        features, targets = (np.vstack(parts) for parts in zip(*flights, strict=True))
        mean, deviation = features.mean(axis=0), features.std(axis=0)
        scale = np.where(deviation > 1e-9, deviation, 1.0)
        penalty = np.sqrt(alpha * len(features)) * np.eye(len(mean))
        slope, *_ = np.linalg.lstsq(
            np.vstack([(features - mean) / scale, penalty]),
            np.vstack([targets - targets.mean(axis=0), np.zeros((len(mean), 3))]),
            rcond=None,
        )
        return cls(mean, scale, np.column_stack([slope.T, targets.mean(axis=0)]), alpha)

    @classmethod
    def fit_ridge(cls, flights: Sequence[Samples], validation: Sequence[Samples]) -> Self:
        """Returns the fit with the penalty of `ALPHAS` that minimises the validation error."""
        fits = [cls.fit(flights, alpha) for alpha in ALPHAS]
        return min(
            fits,
            key=lambda fit: sum(float(((fit.predict(f) - t) ** 2).sum()) for f, t in validation),
        )

    def predict(self, features: np.ndarray) -> np.ndarray:
        """Returns the predicted targets (T, 3) in m/s from features (T, m)."""
        scaled = (features - self.mean) / self.scale
        return scaled @ self.coefficients[:, :-1].T + self.coefficients[:, -1]
