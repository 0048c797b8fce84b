"""Plan of a sweep: a scenario and distributions of some of its keys."""

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from operator import getitem
from typing import Any, ClassVar, Self

from aerodrake.scenario import Scenario
from aerodrake.scenario.inputs import named_files
from aerodrake.scenario.overrides import Override, apply
from aerodrake.scenario.schema import as_mapping
from aerodrake.station import make_closed_loop
from aerodrake.support.arguments import check_whole
from aerodrake.support.errors import BadInput, ScenarioError, show
from aerodrake.support.limits import SEED, TRIALS
from aerodrake.support.version import __version__
from aerodrake.sweeps.distributions import VARY, Choice, Distribution, Linspace, make_rng
from aerodrake.sweeps.distributions import parse_distribution as parse
from aerodrake.sweeps.study_files import StudyFiles
from aerodrake.sweeps.trial import Trial

TRIED = 10
"""Number of trials of which at least one must be a scenario that can be flown."""


@dataclass(frozen=True)
class Plan:
    """Plan of a sweep, from which each trial follows independently of the others.

    Attributes:
        files: Names of its files.
        scenario: Scenario that all trials share; its seed is the sweep's.
        trials: Number of trials.
        vary: Distribution of each varied key.
        integer_keys: Varied keys whose values are whole numbers.
    """

    files: ClassVar[StudyFiles] = StudyFiles("sweep")

    scenario: Scenario
    trials: int
    vary: Mapping[str, Distribution]
    integer_keys: frozenset[str] = frozenset()

    @classmethod
    def make(cls, scenario: Scenario, vary: Mapping[str, str], trials: int | None = None) -> Self:
        """Returns a plan in which each distribution is checked against the range of its key.

        Values of `normal` may still be out of range, and values may contradict each other; the
        rows of such trials have the exit reason `refused`.

        Args:
            scenario: Scenario that all trials share.
            vary: Distribution of each dotted key, as text.
            trials: Number of trials; None for one pass over the grid.

        Raises:
            BadInput: with the argument and the key.
        """
        if not isinstance(vary, Mapping):
            expected = "expected a mapping of dotted keys to distributions"
            raise BadInput(VARY, "", f"{expected}, got {vary!r:.50}")
        distributions: dict[str, Distribution] = {}
        for key, distribution in vary.items():
            if not isinstance(key, str):
                raise BadInput(VARY, "", f"expected dotted keys, got {show(key)}")
            for other in distributions:
                if _overlap(key, other):
                    raise BadInput(VARY, key, f"expected each key once, but {other} contains it")
            distributions[key] = parse(distribution, key)
        grid = [d.count for d in distributions.values() if isinstance(d, Linspace)]
        if trials is None and not grid:
            expected = "expected a number of trials, since no linspace() spans a grid"
            raise BadInput("trials", "", expected)
        count = math.prod(grid) if trials is None else trials
        check_whole("trials", count, *TRIALS)
        return cls(scenario, int(count), distributions, _integer_keys(scenario, distributions))

    def trial(self, index: int) -> Trial:
        """Returns a trial, in which each value depends on seed, index and key alone.

        The first key of a grid changes fastest, so that another key does not change its values.
        """
        seed = int(make_rng(self.scenario.seed, index, "seed").integers(SEED[1] + 1))
        parameters: dict[str, Any] = {}
        cell = index
        for key, distribution in self.vary.items():
            if isinstance(distribution, Linspace):
                cell, step = divmod(cell, distribution.count)
                value: Any = distribution.value(step)
            else:
                value = distribution.draw(make_rng(self.scenario.seed, index, key))
            parameters[key] = _as_integer(value) if key in self.integer_keys else value
        return Trial(index, int(parameters.get("seed", seed)), parameters, self.scenario)

    def check(self) -> None:
        """Builds the closed loop of a trial, which reads the files that the scenario names.

        Raises:
            BadInput: if none of the first `TRIED` trials can be flown: the error of the scenario
                that they share, or else that of the first trial.
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
        """Returns the content of `sweep.json`; the scenario has a file of its own."""
        return {
            "scenario": self.scenario.name,
            "version": __version__,
            "seed": self.scenario.seed,
            "trials": self.trials,
            "vary": {key: str(distribution) for key, distribution in self.vary.items()},
        }


def _integer_keys(scenario: Scenario, vary: Mapping[str, Distribution]) -> frozenset[str]:
    """Returns the keys of whole numbers, after a check of the values of each distribution.

    Keys are set in order, since some exist only with an earlier one: `reference.kind` determines
    the other keys of `reference`.
    """
    keys, fields, files = set(), vars(scenario), {*named_files(scenario)}
    for key, distribution in vary.items():
        probed = [apply(fields, [Override(VARY, key, probe)]) for probe in distribution.probes]
        if any({*named_files(other)} - files for other in probed):
            expected = "expected a packaged file; others are set once for the whole sweep"
            raise BadInput(VARY, key, expected)
        fields = probed[0]
        if type(reduce(getitem, _parts(key), as_mapping(fields))) is int:
            if not isinstance(distribution, Choice | Linspace):
                kinds = f"{Choice.form} or {Linspace.form}"
                raise BadInput(VARY, key, f"is a whole number; expected {kinds}")
            keys.add(key)
    return frozenset(keys)


def _overlap(one: str, other: str) -> bool:
    """Returns True if two dotted keys are equal, or one contains the other."""
    short, long = sorted((_parts(one), _parts(other)), key=len)
    return long[: len(short)] == short


def _parts(key: str) -> list[str | int]:
    """Returns the names and indices in a dotted key."""
    words = key.replace("[", ".[").split(".")
    return [int(w[1:-1]) if re.fullmatch(r"\[\d+\]", w) else w for w in words]


def _as_integer(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value
