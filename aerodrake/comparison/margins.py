"""Robustness margins: disturbances that grow until the error doubles and the flight is lost."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import partial
from itertools import product, takewhile
from typing import Any

from aerodrake.comparison.margin_search import Outcome, Search
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import failure, summarize
from aerodrake.scenario import Scenario
from aerodrake.support.processes import run_parallel

R40 = (
    *(1.00, 1.06, 1.12, 1.18, 1.25, 1.32, 1.40, 1.50, 1.60, 1.70, 1.80, 1.90, 2.00, 2.12),
    *(2.24, 2.36, 2.50, 2.65, 2.80, 3.00, 3.15, 3.35, 3.55, 3.75, 4.00, 4.25, 4.50, 4.75),
    *(5.00, 5.30, 5.60, 6.00, 6.30, 6.70, 7.10, 7.50, 8.00, 8.50, 9.00, 9.50),
)
"""One decade of the preferred numbers of ISO 3, 6 % apart: the resolution of a margin."""

DECADES = range(-3, 1)


@dataclass(frozen=True)
class Disturbance:
    """A value that is added to a key of a scenario, or a factor on it.

    Attributes:
        section, key: The key of the scenario.
        start: The value without effect: 0 if it is added, 1 if it is a factor.
        first: The smallest disturbance; in the key's unit, or a factor.
        end: The largest disturbance; the search ends earlier at the end of the key's range.
        in_steps: True for a time that is a whole number of plant steps.
    """

    section: str
    key: str
    start: float
    first: float
    end: float
    in_steps: bool = False

    def values(self, scenario: Scenario) -> tuple[float, ...]:
        """Returns `start` and the preferred numbers from `first` to `end` that are valid."""
        low, high = sorted((self.first, self.end))
        numbers = (round(number * 10.0**decade, 9) for decade in DECADES for number in R40)
        numbers = [number for number in numbers if low <= number <= high]
        if self.in_steps:
            step = scenario.rates.plant_step_s
            numbers = [round(step * max(1, round(number / step)), 12) for number in numbers]
        outward = sorted({*numbers}, reverse=self.end < self.start)
        return (self.start, *takewhile(partial(self._is_valid, scenario), outward))

    def apply(self, scenario: Scenario, value: float) -> Scenario:
        """Returns the scenario with `value` added to the key, or the key multiplied by it."""
        total = {self.key: self._total(scenario, value)}
        return replace(
            scenario, **{self.section: replace(getattr(scenario, self.section), **total)}
        )

    def _total(self, scenario: Scenario, value: float) -> float:
        own = getattr(getattr(scenario, self.section), self.key)
        return own * value if self.start else own + value

    def _is_valid(self, scenario: Scenario, value: float) -> bool:
        declared = {f.name: f.metadata for f in fields(getattr(scenario, self.section))}[self.key]
        return declared["low"] <= self._total(scenario, value) <= declared["high"]


DISTURBANCES: dict[str, Disturbance] = {
    # End: ten ticks of the MPC of the packaged scenarios.
    "delay_s": Disturbance("sensors", "base_delay_s", 0.0, 0.001, 0.2, in_steps=True),
    # Ends: the key's range.
    "thrust_up": Disturbance("mismatch", "thrust_scale", 1.0, 1.06, 5.0),
    "thrust_down": Disturbance("mismatch", "thrust_scale", 1.0, 0.95, 0.1),
    # First: 1 % of the packaged vehicle's mass. End: the key's range, half of that mass.
    "payload_kg": Disturbance("payload", "mass_kg", 0.0, 0.04, 2.0),
}
"""Disturbances by their names in `margins.json`.

Delay of all base measurements and mass at the end-effector are added to the scenario's.
`thrust_up` and `thrust_down` are factors on the deviation of each rotor's thrust from trim.
"""


@dataclass(frozen=True)
class Margins:
    """Margins of several variants of a scenario.

    Attributes:
        key: Key of `summary["error"]`: the error that doubles.
        searches: Search of each variant and disturbance.
    """

    key: str
    searches: Mapping[str, Mapping[str, Search]]

    def outcomes(self, variant: str) -> list[Outcome]:
        """Returns the outcomes of all flights of a variant, the undisturbed one first."""
        return [o for search in self.searches[variant].values() for o in search.outcomes.values()]

    @property
    def failed(self) -> bool:
        """Returns True if the process of any flight raised or died."""
        return any(o.exit_reason == "failed" for name in self.searches for o in self.outcomes(name))


def find_margins(
    variants: Mapping[str, Scenario],
    summaries: Mapping[str, Mapping[str, Any]],
    key: str,
    jobs: int,
    progress: Callable[[], None] = lambda: None,
) -> Margins:
    """Flies each variant with each disturbance until all searches are complete.

    Each flight has a process of its own. The searches are independent, so that the result does
    not depend on `jobs` or on the order in which flights end.

    Args:
        variants: Scenarios by name.
        summaries: Summaries of their undisturbed flights, as from `compare`.
        key: Key of `summary["error"]`: the error that is to double.
        jobs: Number of concurrent processes.
        progress: Called after each flight.
    """
    searches = {
        name: {
            label: Search(disturbance.values(variant), {0: Outcome.of(summaries[name], key)})
            for label, disturbance in DISTURBANCES.items()
        }
        for name, variant in variants.items()
    }
    queued: list[tuple[str, str, int]] = []
    flights: list[Scenario] = []

    def queue_next(name: str, label: str) -> None:
        search = searches[name][label]
        if (index := search.next()) is not None:
            queued.append((name, label, index))
            flights.append(DISTURBANCES[label].apply(variants[name], search.values[index]))

    for name, label in product(variants, DISTURBANCES):
        queue_next(name, label)
    for flight, summary in run_parallel(_fly, flights, jobs):
        name, label, index = queued[flight]
        if isinstance(summary, Exception):
            summary = failure(summary)
        searches[name][label].outcomes[index] = Outcome.of(summary, key)
        progress()
        queue_next(name, label)
    return Margins(key, searches)


def _fly(scenario: Scenario) -> dict[str, Any]:
    return summarize(scenario, FlightSimulation(scenario).fly())
