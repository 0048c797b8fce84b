"""Robustness, measured: what is added to a scenario until its error doubles and it is lost."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import takewhile
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
"""A decade of the preferred numbers of ISO 3, 6 % apart: a margin is known to that."""

DECADES = range(-3, 1)


@dataclass(frozen=True)
class Disturbance:
    """What is added to a key of a scenario, or by what factor it is taken.

    Attributes:
        section, key: Where in the scenario.
        start: What changes nothing: 0 of what is added, 1 of a factor.
        first: The next value; like both others in the key's unit, or a factor.
        end: Where the search ends; before, where the key's range does.
        in_steps: Whether it is a time of whole plant steps.
    """

    section: str
    key: str
    start: float
    first: float
    end: float
    in_steps: bool = False

    def values(self, scenario: Scenario) -> tuple[float, ...]:
        """From `start` to `end`, preferred numbers between them."""
        low, high = sorted((self.first, self.end))
        numbers = (round(number * 10.0**decade, 9) for decade in DECADES for number in R40)
        numbers = [number for number in numbers if low <= number <= high]
        if self.in_steps:
            step = scenario.rates.plant_step_s
            numbers = [round(step * max(1, round(number / step)), 12) for number in numbers]
        outward = sorted({*numbers}, reverse=self.end < self.start)
        return (self.start, *takewhile(partial(self._is_valid, scenario), outward))

    def apply(self, scenario: Scenario, value: float) -> Scenario:
        """The scenario with so much more of it, in the key's unit, or such a factor on it."""
        section = dataclasses.replace(
            getattr(scenario, self.section), **{self.key: self._total(scenario, value)}
        )
        return dataclasses.replace(scenario, **{self.section: section})

    def _total(self, scenario: Scenario, value: float) -> float:
        own = getattr(getattr(scenario, self.section), self.key)
        return own * value if self.start else own + value

    def _is_valid(self, scenario: Scenario, value: float) -> bool:
        fields = dataclasses.fields(getattr(scenario, self.section))
        (range_,) = (f.metadata for f in fields if f.name == self.key)
        return range_["low"] <= self._total(scenario, value) <= range_["high"]


DISTURBANCES: dict[str, Disturbance] = {
    # To ten ticks of the packaged scenarios' MPC.
    "delay_s": Disturbance("sensors", "base_delay_s", 0.0, 0.001, 0.2, in_steps=True),
    # To the ends of the key's range.
    "thrust_up": Disturbance("mismatch", "thrust_scale", 1.0, 1.06, 5.0),
    "thrust_down": Disturbance("mismatch", "thrust_scale", 1.0, 0.95, 0.1),
    # From 1 % of the packaged vehicle's mass to the end of the key's range, half of it.
    "payload_kg": Disturbance("payload", "mass_kg", 0.0, 0.04, 2.0),
}
"""By the name under which `margins.json` has them.

Delay of all base measurements and mass at the end-effector, both on top of the
scenario's; the factor on how far each rotor's thrust is from trim, up and down.
"""


@dataclass(frozen=True)
class Margins:
    """What was found of each variant.

    Attributes:
        key: Of `summary["error"]`: the error that doubles.
        searches: By variant and disturbance.
    """

    key: str
    searches: Mapping[str, Mapping[str, Search]]

    def outcomes(self, variant: str) -> list[Outcome]:
        """Of all its flights; the first is that without any disturbance."""
        return [o for search in self.searches[variant].values() for o in search.flown.values()]

    @property
    def failed(self) -> bool:
        """Whether there is a flight whose process raised or died."""
        outcomes = (o for variant in self.searches for o in self.outcomes(variant))
        return any(outcome.exit_reason == "failed" for outcome in outcomes)


def find_margins(
    variants: Mapping[str, Scenario],
    summaries: Mapping[str, Mapping[str, Any]],
    key: str,
    jobs: int,
    progress: Callable[[], None] = lambda: None,
) -> Margins:
    """Flies each variant under each disturbance, as long as its search has something to ask.

    Each flight has a process of its own. No search knows of another, so that the
    result does not depend on `jobs` or on which flight ends first.

    Args:
        variants: By name.
        summaries: Of their flights without any disturbance, as from `compare`.
        key: Of `summary["error"]`: the error that is to double.
        jobs: How many processes at a time.
        progress: Called after each flight.
    """
    searches = {
        name: {
            what: Search(made.values(variant), {0: Outcome.of(summaries[name], key)})
            for what, made in DISTURBANCES.items()
        }
        for name, variant in variants.items()
    }
    asked: list[tuple[str, str, int]] = []
    flights: list[Scenario] = []

    def ask(name: str, what: str) -> None:
        search = searches[name][what]
        index = search.next()
        if index is not None:
            asked.append((name, what, index))
            flights.append(DISTURBANCES[what].apply(variants[name], search.values[index]))

    for name in variants:
        for what in DISTURBANCES:
            ask(name, what)
    for flight, summary in run_parallel(_fly, flights, jobs):
        name, what, index = asked[flight]
        if isinstance(summary, Exception):
            summary = failure(summary)
        searches[name][what].flown[index] = Outcome.of(summary, key)
        progress()
        ask(name, what)
    return Margins(key, searches)


def _fly(scenario: Scenario) -> dict[str, Any]:
    return summarize(scenario, FlightSimulation(scenario).fly())
