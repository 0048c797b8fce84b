"""How well base velocity is predicted on flights that nothing was trained on."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from aerodrake.learning.stages import Stage
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.model.residual.samples import Samples
from aerodrake.scenario import Residual

METHODS = ("none", "offline", "online", "linear", "ridge")
"""No residual, the network as trained, learning online, and the linear models."""

ADDS_AT_LEAST = 0.1
"""What wind or payload adds to the offline network's RMSE counts from this part of it."""


@dataclass(frozen=True)
class Evaluation:
    """RMS errors of the velocity predicted one period ahead, m/s.

    Attributes:
        stages: The flights.
        rmse: m/s, for each flight, by method.
    """

    stages: Sequence[Stage]
    rmse: Sequence[Mapping[str, float]]

    @property
    def removed(self) -> float:
        """The smallest part of the residual's RMSE that the offline network removes in calm air."""
        return min(
            1 - rmse["offline"] / rmse["none"]
            for stage, rmse in zip(self.stages, self.rmse, strict=True)
            if not stage.twin
        )

    @property
    def worst(self) -> float:
        """The largest ratio of the offline network's RMSE to that without any."""
        return max(rmse["offline"] / rmse["none"] for rmse in self.rmse)

    def recovered(self, index: int) -> float | None:
        """The part of what wind or payload adds that learning online takes away again.

        Args:
            index: Of the flight.

        Returns:
            None in calm air, and where less than `ADDS_AT_LEAST` is added.
        """
        twins = {s.name: rmse["offline"] for s, rmse in zip(self.stages, self.rmse, strict=True)}
        calm = twins.get(self.stages[index].twin, math.inf)
        offline, online = (self.rmse[index][method] for method in ("offline", "online"))
        if offline < (1 + ADDS_AT_LEAST) * calm:
            return None
        return (offline - online) / (offline - calm)

    @property
    def least_recovered(self) -> float | None:
        """The smallest `recovered` of all flights; None where there is none."""
        parts = (self.recovered(i) for i in range(len(self.stages)))
        return min((part for part in parts if part is not None), default=None)

    def as_mapping(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "rmse_m_s": {s.name: dict(r) for s, r in zip(self.stages, self.rmse, strict=True)},
            "removed": self.removed,
            "recovered": {s.name: self.recovered(i) for i, s in enumerate(self.stages) if s.twin},
            "worst_ratio": self.worst,
        }


def evaluate(
    stages: Sequence[Stage],
    flights: Mapping[str, Samples],
    network: ResidualNetwork,
    gain: np.ndarray,
    residual: Residual,
    linear: LinearResidual,
    ridge: LinearResidual,
) -> Evaluation:
    """Predicts every flight with every method of `METHODS`.

    Args:
        stages: The flights held out.
        flights: Their samples, by name.
        network: As trained offline.
        gain: (3,) c, the diagonal of the model's C in the rows of p_B'.
        residual: Learning rate, batch and guards of online learning.
        linear, ridge: The linear models.
    """
    learner = OnlineLearner(residual, network.last_layer(), gain)
    rows = []
    for stage in stages:
        features, targets = flights[stage.name]
        phi = network.phi(features)
        never = np.zeros(len(phi), dtype=bool)  # No stage saturates the flight controller.
        predicted = {
            "none": np.zeros_like(targets),
            "offline": gain * (phi @ network.last_layer().T),
            "online": gain * learner.run(phi, targets, never),
            "linear": linear.predict(features),
            "ridge": ridge.predict(features),
        }
        rows.append({method: _rms(predicted[method] - targets) for method in METHODS})
    return Evaluation(stages, rows)


def _rms(error: np.ndarray) -> float:
    """Root of the mean squared length of the rows."""
    return float(np.sqrt((error**2).sum(axis=1).mean()))
