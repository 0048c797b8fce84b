"""From what the values of a scenario's key are taken, and how a person writes it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from aerodrake.scenario.plain_yaml import dump_line, parse
from aerodrake.support.errors import BadInput, nearest

VARY = "--vary"

MOST_STEPS = 100_000
"""Of a grid along one key."""


@dataclass(frozen=True)
class Uniform:
    """Any number from `low` to `high`, each as likely.

    Raises:
        ValueError: with what was expected instead.
    """

    low: float
    high: float

    form: ClassVar[str] = "uniform(a, b)"

    def __post_init__(self):
        if not (_are_numbers(self.low, self.high) and self.low < self.high):
            raise ValueError("expected two numbers, the lower one first")

    def __str__(self) -> str:
        return f"uniform({self.low!r}, {self.high!r})"

    @property
    def probes(self) -> tuple[float, ...]:
        """Values that are valid for a key if all are."""
        return self.low, self.high

    def draw(self, rng: np.random.Generator) -> float:
        """One value."""
        return float(rng.uniform(self.low, self.high))


@dataclass(frozen=True)
class Normal:
    """Numbers around `mean`, most of them no further than `deviation`.

    Raises:
        ValueError: with what was expected instead.
    """

    mean: float
    deviation: float

    form: ClassVar[str] = "normal(m, s)"

    def __post_init__(self):
        if not (_are_numbers(self.mean, self.deviation) and self.deviation > 0):
            raise ValueError("expected a mean and a standard deviation above 0")

    def __str__(self) -> str:
        return f"normal({self.mean!r}, {self.deviation!r})"

    @property
    def probes(self) -> tuple[float, ...]:
        """The mean: a value far from it may be out of a key's range."""
        return (self.mean,)

    def draw(self, rng: np.random.Generator) -> float:
        """One value."""
        return float(rng.normal(self.mean, self.deviation))


@dataclass(frozen=True)
class Choice:
    """One of some values, each as likely: numbers, words, truth values, or lists of numbers.

    Raises:
        ValueError: with what was expected instead.
    """

    values: tuple[Any, ...]

    form: ClassVar[str] = "choice(x, y, ...)"

    def __post_init__(self):
        if not self.values or not all(_is_plain(value) for value in self.values):
            raise ValueError("expected numbers, words or lists of numbers, one at least")

    def __str__(self) -> str:
        return f"choice({', '.join(map(dump_line, self.values))})"

    @property
    def probes(self) -> tuple[Any, ...]:
        """All of them."""
        return self.values

    def draw(self, rng: np.random.Generator) -> Any:
        """One value."""
        return self.values[int(rng.integers(len(self.values)))]


@dataclass(frozen=True)
class Linspace:
    """A grid: `count` numbers at even distances, from `low` to `high`.

    Raises:
        ValueError: with what was expected instead.
    """

    low: float
    high: float
    count: int

    form: ClassVar[str] = "linspace(a, b, n)"

    def __post_init__(self):
        is_count = isinstance(self.count, int) and not isinstance(self.count, bool)
        if not (_are_numbers(self.low, self.high) and is_count and 2 <= self.count <= MOST_STEPS):
            raise ValueError(f"expected two numbers, and how many of them: 2 to {MOST_STEPS}")

    def __str__(self) -> str:
        return f"linspace({self.low!r}, {self.high!r}, {self.count})"

    @property
    def probes(self) -> tuple[float, ...]:
        """The ends, and the one after the first, which tells whether all are whole numbers."""
        return self.value(0), self.value(1), self.value(self.count - 1)

    def value(self, index: int) -> float:
        """One of them, by its place in the grid."""
        share = index / (self.count - 1)
        return float(self.low * (1 - share) + self.high * share)


Distribution = Uniform | Normal | Choice | Linspace

KINDS: dict[str, type[Any]] = {
    "uniform": Uniform,
    "normal": Normal,
    "choice": Choice,
    "linspace": Linspace,
}


def parse_distribution(text: str, key: str) -> Distribution:
    """Reads `uniform(0, 2)` and the like.

    Args:
        text: What a person wrote.
        key: The scenario's key that it is for, named in errors.

    Raises:
        BadInput: that names `--vary`, the key and what was expected.
    """
    found = re.fullmatch(r"\s*(\w+)\s*\((.*)\)\s*", text)
    if not found:
        forms = ", ".join(kind.form for kind in KINDS.values())
        raise BadInput(VARY, key, f"expected one of {forms}, got '{text}'")
    name, inside = found.groups()
    if name not in KINDS:
        raise BadInput(VARY, key, f"no such distribution '{name}'; {nearest(name, KINDS)}")
    kind, values = KINDS[name], parse(f"[{inside}]", VARY, key)
    try:
        return Choice(tuple(values)) if kind is Choice else kind(*values)
    except (TypeError, ValueError) as error:
        expected = f": {error}" if isinstance(error, ValueError) else ""
        raise BadInput(VARY, key, f"expected {kind.form}{expected}, got '{text}'") from None


def make_rng(seed: int, trial: int, key: str) -> np.random.Generator:
    """What a key's value of a trial is drawn by: a function of these three and of nothing else."""
    return np.random.default_rng(np.random.SeedSequence([seed, trial, *key.encode()]))


def _are_numbers(*values: object) -> bool:
    return all(
        isinstance(v, int | float) and not isinstance(v, bool) and math.isfinite(v) for v in values
    )


def _is_plain(value: object) -> bool:
    return isinstance(value, str | bool) or _are_numbers(
        *(value if isinstance(value, list) else [value])
    )
