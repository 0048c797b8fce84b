"""Prediction errors of the base velocity on held-out flights."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from aerodrake.learning.collection_runs import CollectionRun
from aerodrake.model.residual.linear_residual import LinearResidual
from aerodrake.model.residual.network import ResidualNetwork
from aerodrake.model.residual.online_learner import OnlineLearner
from aerodrake.model.residual.samples import Samples

METHODS = ("none", "offline", "online", "linear", "ridge")
"""No residual, the network as trained, learning online, and the linear models."""

MIN_ADDED = 0.1
"""Smallest relative increase of the offline RMSE by wind or payload for `recovered`."""


class Candidates(NamedTuple):
    """Models of the residual to compare.

    Attributes:
        network: Network as trained offline.
        learner: Starts from the network's last layer, times c.
        linear, ridge: Linear models.
    """

    network: ResidualNetwork
    learner: OnlineLearner
    linear: LinearResidual
    ridge: LinearResidual

    def predict(self, samples: Samples) -> dict[str, np.ndarray]:
        """Returns the predicted targets of a flight, (T, 3) m/s, for each of `METHODS`."""
        features, targets = samples
        phi = self.network.phi(features)
        saturated = np.zeros(len(phi), dtype=bool)  # No run saturates the flight controller.
        return {
            "none": np.zeros_like(targets),
            "offline": phi @ self.learner.theta_offline.T,
            "online": self.learner.run(phi, targets, saturated),
            "linear": self.linear.predict(features),
            "ridge": self.ridge.predict(features),
        }


@dataclass(frozen=True)
class NetworkEvaluation:
    """RMS errors of the velocity predicted one period ahead, m/s.

    Attributes:
        runs: The held-out runs.
        rmse: m/s, for each run, by method.
    """

    runs: Sequence[CollectionRun]
    rmse: Sequence[Mapping[str, float]]

    @property
    def removed(self) -> float:
        """Smallest fraction of the residual's RMSE that the offline network removes in calm air."""
        return min(
            1 - rmse["offline"] / rmse["none"]
            for run, rmse in zip(self.runs, self.rmse, strict=True)
            if not run.twin
        )

    @property
    def worst(self) -> float:
        """Largest ratio of the offline network's RMSE to that without a network."""
        return max(rmse["offline"] / rmse["none"] for rmse in self.rmse)

    def recovered(self, index: int) -> float | None:
        """Returns the fraction of the RMSE added by wind or payload that online learning removes.

        Returns None in calm air, and if less than `MIN_ADDED` is added.
        """
        twins = {run.name: rmse["offline"] for run, rmse in zip(self.runs, self.rmse, strict=True)}
        calm = twins.get(self.runs[index].twin, math.inf)
        offline, online = self.rmse[index]["offline"], self.rmse[index]["online"]
        if offline < (1 + MIN_ADDED) * calm:
            return None
        return (offline - online) / (offline - calm)

    @property
    def least_recovered(self) -> float | None:
        """Smallest `recovered` of all runs; None if no run has one."""
        fractions = map(self.recovered, range(len(self.runs)))
        return min((part for part in fractions if part is not None), default=None)

    def as_mapping(self) -> dict[str, Any]:
        """Returns the evaluation for JSON."""
        return {
            "rmse_m_s": {r.name: dict(rmse) for r, rmse in zip(self.runs, self.rmse, strict=True)},
            "removed": self.removed,
            "recovered": {r.name: self.recovered(i) for i, r in enumerate(self.runs) if r.twin},
            "worst_ratio": self.worst,
        }


def evaluate(
    runs: Sequence[CollectionRun], flights: Mapping[str, Samples], candidates: Candidates
) -> NetworkEvaluation:
    """Predicts every held-out run from its samples in `flights`, with every candidate."""
    rows = []
    for run in runs:
        predicted, (_, targets) = candidates.predict(flights[run.name]), flights[run.name]
        squares = {name: ((p - targets) ** 2).sum(axis=1) for name, p in predicted.items()}
        rows.append({name: float(np.sqrt(square.mean())) for name, square in squares.items()})
    return NetworkEvaluation(runs, rows)
