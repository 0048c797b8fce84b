"""Search for the magnitude of a disturbance that a configuration tolerates."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from operator import attrgetter
from typing import Any, Self

COARSE = 8
"""Stride of the coarse search over the values, which bisection then refines."""

LEAST_ERROR_M = 1e-6
"""m, level of rounding: an error counts as doubled only above twice this."""


@dataclass(frozen=True)
class Outcome:
    """Error and end of one flight.

    Attributes:
        error_m: m, the error by which flights are compared; None if the flight did not last for it.
        exit_reason: As in `summary.json`; `failed` if the process raised or died.
        exit_cause: As in `summary.json`, or the reason of the failure.
    """

    error_m: float | None
    exit_reason: str
    exit_cause: str = ""

    @classmethod
    def of(cls, summary: Mapping[str, Any], key: str) -> Self:
        """Returns the outcome of a flight; `key` is that of `summary["error"]`."""
        error = summary.get("error", {}).get(key)
        return cls(error, summary["exit_reason"], summary["exit_cause"])

    @property
    def is_lost(self) -> bool:
        """Returns True if the flight was not completed."""
        return self.exit_reason != "completed"


_is_lost = attrgetter("is_lost")

Bracket = tuple[float | None, float | None]
"""The last value before an event (doubled error, lost flight), and the first with it."""


@dataclass
class Search:
    """Search for the values at which the error first doubles and a flight is first not completed.

    Every `COARSE`-th value is flown until a flight is lost or the last value is reached. Then the
    first interval in which a flight is lost is bisected until its ends are adjacent values, and
    after it the first interval in which the error doubles. The error need not grow monotonically
    with the disturbance: the result is the first crossing among all flights.

    Attributes:
        values: Magnitudes in order of increasing disturbance, from the one without effect, in the
            unit of the scenario's key.
        outcomes: Outcome of each flight, by index into `values`; initially that of index 0.
    """

    values: Sequence[float]
    outcomes: dict[int, Outcome]

    @property
    def doubled_m(self) -> float:
        """m, twice the error of the undisturbed flight."""
        return 2 * max(self.outcomes[0].error_m or 0.0, LEAST_ERROR_M)

    def next(self) -> int | None:
        """Returns the index of the next value to fly; None if the search is complete."""
        farthest, last = max(self.outcomes), len(self.values) - 1
        if farthest < last and not any(outcome.is_lost for outcome in self.outcomes.values()):
            return min((farthest // COARSE + 1) * COARSE, last)
        for crosses in (_is_lost, self._is_doubled):
            before, crossed = self._bracket(crosses)
            if before is not None and crossed is not None and crossed > before + 1:
                return (before + crossed) // 2
        return None

    @property
    def doubles(self) -> Bracket:
        """Returns the bracket of the doubled error; lost flights count as doubled.

        It is (None, first value) if the undisturbed flight has no error to double, and
        (last value, None) if the error never doubles.
        """
        return self._values(self._is_doubled)

    @property
    def lost(self) -> Bracket:
        """Returns the bracket of the first lost flight, as for `doubles`."""
        return self._values(_is_lost)

    def _is_doubled(self, outcome: Outcome) -> bool:
        error = outcome.error_m
        return outcome.is_lost or error is None or error >= self.doubled_m

    def _values(self, crosses: Callable[[Outcome], bool]) -> Bracket:
        indices = self._bracket(crosses)
        before, crossed = (None if i is None else self.values[i] for i in indices)
        return before, crossed

    def _bracket(self, crosses: Callable[[Outcome], bool]) -> tuple[int | None, int | None]:
        """Returns the indices of the last flight before a crossing and of the first crossing."""
        indices = sorted(self.outcomes)
        if crosses(self.outcomes[indices[0]]):
            return None, indices[0]
        crossings = ((i, j) for i, j in pairwise(indices) if crosses(self.outcomes[j]))
        return next(crossings, (indices[-1], None))
