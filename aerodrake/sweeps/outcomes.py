"""What came of a sweep: how its flights ended, and how large their errors were."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from aerodrake.flight.summary import HEADLINES
from aerodrake.sweeps.folder import read_rows
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.trial import FAILURES

FEWEST = 3
"""Trials of which there is a rank correlation."""


@dataclass(frozen=True)
class Outcomes:
    """What the rows of a sweep say, one element a trial, in their order.

    Attributes:
        trials: (T,) their indices.
        endings: How each flight ended.
        error_m: (T,) m, the headline error of each; nan where the flight was not completed.
        parameters: The values of each key that is varied.
        key: Of a row's `error`: which of them it is.
    """

    trials: np.ndarray
    endings: Sequence[str]
    error_m: np.ndarray
    parameters: Mapping[str, Sequence[Any]]
    key: str

    @classmethod
    def read(cls, folder: Path, plan: Plan) -> Outcomes:
        """From the rows of a sweep's folder: the first headline that each completed flight has."""
        trials, endings = [], []
        errors: dict[str, list[float]] = {key: [] for key in HEADLINES}
        for trial, ending, error in sorted(_brief(folder), key=lambda brief: brief[0]):
            trials.append(trial)
            endings.append(ending)
            for key, values in errors.items():
                value = error[key] if ending == "completed" else None
                values.append(np.nan if value is None else value)
        is_completed = np.array([ending == "completed" for ending in endings], dtype=bool)
        arrays = {key: np.array(values, dtype=float) for key, values in errors.items()}
        whole = (k for k in HEADLINES if np.isfinite(arrays[k][is_completed]).all())
        key = next(whole, "mean_m")
        drawn = [plan.trial(index).parameters for index in trials]
        parameters = {name: [values[name] for values in drawn] for name in plan.vary}
        return cls(np.array(trials, dtype=int), endings, arrays[key], parameters, key)

    @property
    def completed(self) -> np.ndarray:
        """(T,) which of them have an error."""
        return np.isfinite(self.error_m)

    def worst(self, most: int) -> list[int]:
        """Places of the worst: those not completed, then those of the largest error."""
        order = np.lexsort((self.trials, -np.nan_to_num(self.error_m, nan=np.inf)))
        return [int(place) for place in order[:most]]

    def correlation(self, name: str) -> tuple[float, float] | None:
        """Spearman's rank correlation of a key with the error, and its p-value.

        Of all flights: those that were not completed have the worst rank.
        None if the key's values are no numbers, or they or the errors are all the same.
        """
        values = self.parameters[name]
        if not are_numbers(values):
            return None
        flown = np.array([ending not in FAILURES for ending in self.endings], dtype=bool)
        x, y = np.array(values, dtype=float)[flown], self.error_m[flown]
        y = np.where(np.isfinite(y), y, np.inf)
        if len(x) < FEWEST or min(len(np.unique(x)), len(np.unique(y))) == 1:
            return None
        found = spearmanr(x, y)
        return float(found.statistic), float(found.pvalue)


def are_numbers(values: Sequence[Any]) -> bool:
    """Whether values of a key have an order and distances."""
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def _brief(folder: Path) -> list[tuple[int, str, dict[str, Any]]]:
    """Trial, ending and headline errors: of a hundred thousand rows no more than is needed."""
    return [
        (row["trial"], row["exit_reason"], {k: row.get("error", {}).get(k) for k in HEADLINES})
        for row in read_rows(folder)
    ]
