"""Outcomes of a sweep: exit reasons and errors of its flights."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.stats import spearmanr

from aerodrake.flight.summary import HEADLINES
from aerodrake.sweeps.distributions import Distribution, are_numbers
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
        vary: Distribution of each varied key.
    """

    trials: np.ndarray
    endings: Sequence[str]
    error_m: np.ndarray
    parameters: Mapping[str, Sequence[Any]]
    key: str
    vary: Mapping[str, Distribution]

    @classmethod
    def read(cls, folder: Path, plan: Plan) -> Self:
        """Reads the rows of a sweep's folder.

        The headline is the first of `HEADLINES` that all completed flights have.
        """
        briefs = sorted(map(_brief, read_rows(folder)), key=lambda brief: brief[0])
        trials, endings, errors = ([brief[i] for brief in briefs] for i in range(3))
        is_completed = np.array([ending == "completed" for ending in endings], dtype=bool)
        # (T, K) m, by trial and headline; NaN for null.
        error_m = np.array(errors, dtype=float).reshape(-1, len(HEADLINES))
        error_m[~is_completed] = np.nan
        whole = np.isfinite(error_m[is_completed]).all(axis=0)
        key = next((k for k, is_whole in zip(HEADLINES, whole, strict=True) if is_whole), "mean_m")
        drawn = [plan.trial(index).parameters for index in trials]
        parameters = {name: [values[name] for values in drawn] for name in plan.vary}
        column = error_m[:, list(HEADLINES).index(key)]
        return cls(np.array(trials, dtype=int), endings, column, parameters, key, plan.vary)

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
        if not are_numbers(*values):
            return None
        flown = np.array([ending not in FAILURES for ending in self.endings], dtype=bool)
        x, y = np.array(values, dtype=float)[flown], self.error_m[flown]
        y = np.where(np.isfinite(y), y, np.inf)
        if len(x) < FEWEST or min(len(np.unique(x)), len(np.unique(y))) == 1:
            return None
        result = spearmanr(x, y)
        return float(result.statistic), float(result.pvalue)


def three_digits(value: float) -> str:
    """Formats a positive number with three significant digits or all before the point."""
    if value and not 1e-4 <= value < 1e6:
        return f"{value:.2e}"
    return f"{value:.{max(0, 2 - math.floor(math.log10(value or 1)))}f}"


def _brief(row: Mapping[str, Any]) -> tuple[int, str, list[float | None]]:
    """Returns index, exit reason and headline errors of a row; whole rows need much memory."""
    error = row.get("error", {})
    return row["trial"], row["exit_reason"], [error.get(key) for key in HEADLINES]
