"""The search for how much of a disturbance a configuration stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

COARSE = 8
"""Every so many of the values are flown before any between them."""

LEAST_ERROR_M = 1e-6
"""Smaller errors are rounding; one counts as doubled when it is twice this."""


@dataclass(frozen=True)
class Outcome:
    """How a flight ended.

    Attributes:
        error_m: m, the figure by which flights are compared; None where it was not flown.
        exit_reason: As in `summary.json`; `failed` if there is none.
        exit_cause: The same.
    """

    error_m: float | None
    exit_reason: str
    exit_cause: str = ""

    @classmethod
    def of(cls, summary: Mapping[str, Any], key: str) -> Outcome:
        """That of a flight.

        Args:
            summary: As from `compare`.
            key: Of `summary["error"]`.
        """
        error = summary.get("error", {}).get(key)
        return cls(error, summary["exit_reason"], summary["exit_cause"])

    @property
    def is_lost(self) -> bool:
        """Whether the flight did not end as it should."""
        return self.exit_reason != "completed"


Bracket = tuple[float | None, float | None]
"""The last value at which something does not happen yet, and the first at which it does."""


@dataclass
class Search:
    """Where, going outward along `values`, the error first doubles and the flight is first lost.

    Every `COARSE`-th value is flown until a flight is lost or the last value is
    reached. Then the first interval in which a flight is lost, or an error
    doubled, is halved until its ends are neighbours. Errors need not grow with
    the disturbance: what counts is the first crossing of all that was flown.

    Attributes:
        values: Outward from that which changes nothing, in the unit of the scenario's key.
        flown: What came of it, by index into `values`. It starts with that of 0.
    """

    values: Sequence[float]
    flown: dict[int, Outcome]

    @property
    def doubled_m(self) -> float:
        """m, twice the error of the flight as it is. Lost flights count as doubled."""
        return 2 * max(self.flown[0].error_m or 0.0, LEAST_ERROR_M)

    def next(self) -> int | None:
        """The index of the value that is to be flown next; None where nothing is left to learn."""
        far, last = max(self.flown), len(self.values) - 1
        if far < last and not any(outcome.is_lost for outcome in self.flown.values()):
            return min((far // COARSE + 1) * COARSE, last)
        for crosses in (self._is_lost, self._is_doubled):
            held, crossed = self._bracket(crosses)
            if held is not None and crossed is not None and crossed > held + 1:
                return (held + crossed) // 2
        return None

    @property
    def doubles(self) -> Bracket:
        """Where the error doubles.

        The first of `values` where there is no error to double, the last of all
        where it never does: (None, first), (last, None).
        """
        return self._values(self._is_doubled)

    @property
    def lost(self) -> Bracket:
        """Where the flight is lost: likewise."""
        return self._values(self._is_lost)

    def _is_lost(self, outcome: Outcome) -> bool:
        return outcome.is_lost

    def _is_doubled(self, outcome: Outcome) -> bool:
        error = outcome.error_m
        return outcome.is_lost or error is None or error >= self.doubled_m

    def _values(self, crosses: Callable[[Outcome], bool]) -> Bracket:
        held, crossed = (None if i is None else self.values[i] for i in self._bracket(crosses))
        return held, crossed

    def _bracket(self, crosses: Callable[[Outcome], bool]) -> tuple[int | None, int | None]:
        """The indices of the first that was flown and crosses, and of the one before it."""
        indices = sorted(self.flown)
        if crosses(self.flown[indices[0]]):
            return None, indices[0]
        found = ((i, j) for i, j in pairwise(indices) if crosses(self.flown[j]))
        return next(found, (indices[-1], None))
