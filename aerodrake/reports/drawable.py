"""Logs of flights with values that figures can show, whatever was flown."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from aerodrake.flight.log import FlightLog

LARGEST = 1e9
"""Largest magnitude in a figure, in the unit of the log; that of a diverged signal is larger.

It is far from any quantity of a flight, and from the overflow of its square.
"""


class DrawableSignals(Mapping[str, np.ndarray]):
    """Signals in which NaN stands for values that are infinite or larger than `LARGEST`.

    Lines have gaps there.

    Args:
        signals: Arrays by key, each (T, ...); each is read when it is accessed.
    """

    def __init__(self, signals: Mapping[str, np.ndarray]):
        self._signals = signals

    def __getitem__(self, key: str) -> np.ndarray:
        return drawable_values(self._signals[key])

    def __iter__(self) -> Iterator[str]:
        return iter(self._signals)

    def __len__(self) -> int:
        return len(self._signals)


def drawable_values(values: np.ndarray) -> np.ndarray:
    """Returns the values (T, ...) with NaN for those that are infinite or exceed `LARGEST`."""
    return np.where(np.abs(values) <= LARGEST, values, np.nan)


def drawable(log: FlightLog) -> FlightLog:
    """Returns a log with `DrawableSignals`."""
    return replace(log, signals=DrawableSignals(log.signals))
