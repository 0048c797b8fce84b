"""Outcomes of a sweep: exit reasons and errors of its flights."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.stats import spearmanr

from aerodrake.flight.summary import HEADLINES
from aerodrake.sweeps.folder import read_rows
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.trial import FAILURES

FEWEST = 3
"""Smallest number of trials for a rank correlation."""


@dataclass(frozen=True)
class Outcomes:
    """Outcomes of T trials, in the order of their indices.

    Attributes:
        trials: (T,) index of each trial.
        endings: Exit reason of each trial.
        error_m: (T,) m, headline error of each trial; NaN if the flight was not completed.
        parameters: Values of each varied key.
        key: Key of the headline error in a row's `error`.
    """

    trials: np.ndarray
    endings: Sequence[str]
    error_m: np.ndarray
    parameters: Mapping[str, Sequence[Any]]
    key: str

    @classmethod
    def read(cls, folder: Path, plan: Plan) -> Self:
        """Reads the rows of a sweep's folder.

        The headline is the first of `HEADLINES` that all completed flights have.
        """
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
        """Returns (T,) True for each completed flight."""
        return np.isfinite(self.error_m)

    def worst(self, most: int) -> list[int]:
        """Returns indices of the worst outcomes: not completed first, then by error, descending."""
        order = np.lexsort((self.trials, -np.nan_to_num(self.error_m, nan=np.inf)))
        return [int(index) for index in order[:most]]

    def correlation(self, name: str) -> tuple[float, float] | None:
        """Returns Spearman's rank correlation of a key with the error, and its p-value.

        Flights that were not completed have the worst rank. Returns None if the key's values are
        not numbers, if they or the errors are all equal, or if there are too few flights.
        """
        values = self.parameters[name]
        if not are_numbers(values):
            return None
        flown = np.array([ending not in FAILURES for ending in self.endings], dtype=bool)
        x, y = np.array(values, dtype=float)[flown], self.error_m[flown]
        y = np.where(np.isfinite(y), y, np.inf)
        if len(x) < FEWEST or min(len(np.unique(x)), len(np.unique(y))) == 1:
            return None
        result = spearmanr(x, y)
        return float(result.statistic), float(result.pvalue)


def are_numbers(values: Sequence[Any]) -> bool:
    """Returns True if all values are numbers."""
    return all(isinstance(v, int | float) and not isinstance(v, bool) for v in values)


def _brief(folder: Path) -> list[tuple[int, str, dict[str, Any]]]:
    """Returns index, exit reason and headline errors of each row; whole rows need much memory."""
    return [
        (row["trial"], row["exit_reason"], {k: row.get("error", {}).get(k) for k in HEADLINES})
        for row in read_rows(folder)
    ]
