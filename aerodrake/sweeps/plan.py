"""What a sweep flies: a scenario, some of whose keys have another value in each trial."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import named_files
from aerodrake.scenario.load import set_key
from aerodrake.scenario.plain_yaml import dump_line
from aerodrake.scenario.schema import as_mapping
from aerodrake.station import make_closed_loop
from aerodrake.support.errors import BadInput, ScenarioError
from aerodrake.sweeps.distributions import VARY, Choice, Distribution, Linspace, make_rng
from aerodrake.sweeps.distributions import parse_distribution as parse
from aerodrake.sweeps.trial import Trial

MOST_TRIALS = 100_000

TRIED = 10
"""Trials of which one at least must be of a scenario that can be flown."""

MOST_SEED = 2**31


@dataclass(frozen=True)
class Plan:
    """A sweep. Each trial of it is known without the others.

    Attributes:
        scenario: What all trials have in common; its seed is the sweep's.
        trials: How many.
        vary: From what the values of keys are taken, by key.
        whole: Keys whose values are whole numbers.
    """

    scenario: Scenario
    trials: int
    vary: Mapping[str, Distribution]
    whole: frozenset[str] = frozenset()

    @classmethod
    def make(cls, scenario: Scenario, vary: Iterable[str], trials: int | None = None) -> Plan:
        """A plan that was looked through: no value is out of its key's range.

        That leaves values drawn by `normal`, and such as do not fit each other: their
        trials are refused when it is their turn.

        Args:
            scenario: What is varied.
            vary: `KEY=DISTRIBUTION`, each as `--vary` takes it.
            trials: How many; None for the grid, once.

        Raises:
            BadInput: that names the option and the key.
        """
        distributions: dict[str, Distribution] = {}
        for text in vary:
            key, equals, distribution = text.partition("=")
            key = key.strip()
            if not key or not equals:
                raise BadInput(VARY, "", f"expected dotted.key=distribution, got '{text}'")
            for other in distributions:
                if _overlap(key, other):
                    raise BadInput(VARY, key, f"expected each key once, but {other} holds it too")
            distributions[key] = parse(distribution, key)
        grid = math.prod(d.count for d in distributions.values() if isinstance(d, Linspace))
        is_grid = any(isinstance(d, Linspace) for d in distributions.values())
        if trials is None and not is_grid:
            raise BadInput("--trials", "", "expected how many, since no linspace() spans a grid")
        count = grid if trials is None else trials
        if not 1 <= count <= MOST_TRIALS:
            raise BadInput("--trials", "", f"expected 1 to {MOST_TRIALS}, got {count}")
        return cls(scenario, count, distributions, _whole(scenario, distributions))

    def trial(self, index: int) -> Trial:
        """One trial: a function of the sweep's seed, its index and each key alone.

        A grid's first key changes fastest, so that a key more leaves the others as they are.
        """
        seed = int(make_rng(self.scenario.seed, index, "seed").integers(MOST_SEED))
        parameters: dict[str, Any] = {}
        cell = index
        for key, distribution in self.vary.items():
            if isinstance(distribution, Linspace):
                cell, place = divmod(cell, distribution.count)
                value: Any = distribution.value(place)
            else:
                value = distribution.draw(make_rng(self.scenario.seed, index, key))
            parameters[key] = _as_whole(value) if key in self.whole else value
        return Trial(index, int(parameters.get("seed", seed)), parameters, self.scenario)

    def check(self) -> None:
        """Builds the closed loop of a trial, which reads the files it names.

        Raises:
            BadInput: if none of the first ten can be flown: what is wrong with the scenario
                that they share, or else with the values of the first.
        """
        refusals = []
        for index in range(min(TRIED, self.trials)):
            try:
                make_closed_loop(self.trial(index).resolved())
                return
            except BadInput as error:
                refusals.append(error)
        make_closed_loop(self.scenario)
        _, key, message = refusals[0].args
        raise ScenarioError(VARY, key, f"trial 0: {message}")

    def as_mapping(self) -> dict[str, Any]:
        """What `sweep.json` holds; the scenario stands beside it."""
        return {
            "scenario": self.scenario.name,
            "version": version("aerodrake"),
            "seed": self.scenario.seed,
            "trials": self.trials,
            "vary": {key: str(distribution) for key, distribution in self.vary.items()},
        }


def _whole(scenario: Scenario, vary: Mapping[str, Distribution]) -> frozenset[str]:
    """The keys of whole numbers, after a look at what each distribution can give.

    A key stands on those before it: `reference.kind` makes keys that another kind has not.
    """
    whole, files = set(), {*named_files(scenario)}
    for key, distribution in vary.items():
        probed = [
            set_key(scenario, VARY, f"{key}={dump_line(value)}") for value in distribution.probes
        ]
        for other in probed:
            if {*named_files(other)} - files:
                raise BadInput(VARY, key, "expected no file of your own; set it for a whole sweep")
        scenario = probed[0]
        if type(_value(scenario, key)) is int:
            if not isinstance(distribution, Choice | Linspace):
                raise BadInput(
                    VARY, key, "is a whole number; expected choice(x, y, ...) or linspace(a, b, n)"
                )
            whole.add(key)
    return frozenset(whole)


def _overlap(one: str, other: str) -> bool:
    """Whether a dotted key is another one, or a part of it."""
    short, long = sorted((_parts(one), _parts(other)), key=len)
    return long[: len(short)] == short


def _parts(key: str) -> list[str | int]:
    words = key.replace("[", ".[").split(".")
    return [int(w[1:-1]) if re.fullmatch(r"\[\d+\]", w) else w for w in words]


def _as_whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


def _value(scenario: Scenario, key: str) -> Any:
    node: Any = as_mapping(scenario)
    for name in key.replace("[", ".[").split("."):
        node = node[int(name[1:-1])] if name.startswith("[") else node[name]
    return node
