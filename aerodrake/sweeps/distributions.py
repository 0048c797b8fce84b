"""Distributions of the values of a scenario's key, and their notation."""

import math
import re
from dataclasses import dataclass, fields
from typing import Any, ClassVar

import numpy as np

from aerodrake.scenario.plain_yaml import dump_line, parse
from aerodrake.support.errors import BadInput, nearest

VARY = "vary"
"""Argument that errors name."""

MOST_STEPS = 100_000
"""Largest number of values of a grid along one key."""


class Distribution:
    """Distribution of the values of a key.

    Attributes:
        form: Notation.

    Raises:
        ValueError: for invalid arguments, with the expected ones.
    """

    form: ClassVar[str]

    def __str__(self) -> str:
        arguments = ", ".join(repr(getattr(self, field.name)) for field in fields(self))
        return f"{type(self).__name__.lower()}({arguments})"

    @property
    def probes(self) -> tuple[Any, ...]:
        """Returns the values that are checked against the range of the key."""
        raise NotImplementedError

    def draw(self, rng: np.random.Generator) -> Any:
        """Draws one value; the values of a grid are those of `value(index)` instead."""
        raise NotImplementedError


@dataclass(frozen=True)
class Uniform(Distribution):
    """Uniform distribution from `low` to `high`."""

    low: float
    high: float

    form = "uniform(a, b)"

    def __post_init__(self):
        if not (are_numbers(self.low, self.high) and self.low < self.high):
            raise ValueError("expected two numbers, the lower one first")

    @property
    def probes(self) -> tuple[float, ...]:
        # All values are valid if these are.
        return self.low, self.high

    def draw(self, rng: np.random.Generator) -> float:
        return float(rng.uniform(self.low, self.high))


@dataclass(frozen=True)
class Normal(Distribution):
    """Normal distribution of mean `mean` and standard deviation `deviation`."""

    mean: float
    deviation: float

    form = "normal(m, s)"

    def __post_init__(self):
        if not (are_numbers(self.mean, self.deviation) and self.deviation > 0):
            raise ValueError("expected a mean and a standard deviation above 0")

    @property
    def probes(self) -> tuple[float, ...]:
        """Returns the mean; values far from it may be out of the key's range."""
        return (self.mean,)

    def draw(self, rng: np.random.Generator) -> float:
        return float(rng.normal(self.mean, self.deviation))


@dataclass(frozen=True)
class Choice(Distribution):
    """Equally likely values: numbers, words, booleans, or lists of numbers."""

    values: tuple[Any, ...]

    form = "choice(x, y, ...)"

    def __post_init__(self):
        if not self.values or not all(_is_plain(value) for value in self.values):
            raise ValueError("expected numbers, words or lists of numbers, one at least")

    def __str__(self) -> str:
        return f"choice({', '.join(map(dump_line, self.values))})"

    @property
    def probes(self) -> tuple[Any, ...]:
        return self.values

    def draw(self, rng: np.random.Generator) -> Any:
        return self.values[int(rng.integers(len(self.values)))]


@dataclass(frozen=True)
class Linspace(Distribution):
    """Grid of `count` evenly spaced numbers from `low` to `high`."""

    low: float
    high: float
    count: int

    form = "linspace(a, b, n)"

    def __post_init__(self):
        is_count = isinstance(self.count, int) and not isinstance(self.count, bool)
        if not (are_numbers(self.low, self.high) and is_count and 2 <= self.count <= MOST_STEPS):
            raise ValueError(f"expected two numbers, and how many of them: 2 to {MOST_STEPS}")

    @property
    def probes(self) -> tuple[float, ...]:
        """Returns the ends, and the second value, which is whole only if all values are."""
        return self.value(0), self.value(1), self.value(self.count - 1)

    def value(self, index: int) -> float:
        """Returns the value at an index of the grid."""
        fraction = index / (self.count - 1)
        return float(self.low * (1 - fraction) + self.high * fraction)


KINDS = {kind.__name__.lower(): kind for kind in (Uniform, Normal, Choice, Linspace)}


def parse_distribution(text: str, key: str) -> Distribution:
    """Reads `uniform(0, 2)` and the like, for a key of the scenario.

    Raises:
        BadInput: with `vary`, the key and the expected form.
    """
    match = re.fullmatch(r"\s*(\w+)\s*\((.*)\)\s*", str(text))
    if not match:
        forms = ", ".join(kind.form for kind in KINDS.values())
        raise BadInput(VARY, key, f"expected one of {forms}, got '{text}'")
    name, arguments = match.groups()
    if name not in KINDS:
        raise BadInput(VARY, key, f"no such distribution '{name}'; {nearest(name, KINDS)}")
    kind, values = KINDS[name], parse(f"[{arguments}]", VARY, key)
    try:
        return Choice(tuple(values)) if kind is Choice else kind(*values)
    except (TypeError, ValueError) as error:
        expected = f": {error}" if isinstance(error, ValueError) else ""
        raise BadInput(VARY, key, f"expected {kind.form}{expected}, got '{text}'") from None


def make_rng(seed: int, trial: int, key: str) -> np.random.Generator:
    """Returns the random generator of a key in a trial, a function of these three alone."""
    return np.random.default_rng(np.random.SeedSequence([seed, trial, *key.encode()]))


def are_numbers(*values: object) -> bool:
    """Returns True if all values are finite numbers."""
    return all(
        isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in values
    )


def _is_plain(value: object) -> bool:
    numbers = value if isinstance(value, list) else [value]
    return isinstance(value, str | bool) or are_numbers(*numbers)
