"""A message over the wire: Drake's `lcmt_drake_signal`, numbers, each with its name.

    name                 what
    phase                a `Phase`
    station              number of the station that tells, or is told
    scenario.rates, ...  what the sender flies, by a number for each section of the scenario
    state[4], ...        the parts, one after another

The first three are the header, which ends of different scenarios understand as well. Beside them
is a time stamp, in microseconds.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from drake import lcmt_drake_signal

NUMBERS = 2**48
"""Whole numbers below it are exact as those of a message, and that many do not meet by chance."""


class Phase(IntEnum):
    """What the sender is about.

    WAITING: it is there, and nothing else that it says counts. FLYING: it flies. OVER: the
    flight has ended.
    """

    WAITING = 0
    FLYING = 1
    OVER = 2


class Message(NamedTuple):
    """What was told.

    Attributes:
        time: s, of the sample, or of the tick that is answered.
        phase: Of the sender.
        station: Number of the station that told, or was told.
        parts: (size,) numbers by name. They may be no numbers, as those of a sensor.
        differing: Sections of the sender's scenario that are not as the receiver's. Where there
            are any, parts were not read.
    """

    time: float
    phase: Phase
    station: int
    parts: dict[str, np.ndarray]
    differing: tuple[str, ...] = ()


class Layout:
    """What stands where in a channel's messages.

    Args:
        scenario: Numbers below `NUMBERS` of the scenario's sections, by name, that both ends
            have to agree on: `fingerprint.coordinated`.
        sizes: Of the parts, by name.
    """

    def __init__(self, scenario: Mapping[str, int], sizes: Mapping[str, int]):
        self.scenario, self.sizes = dict(scenario), dict(sizes)
        self._header = ["phase", "station", *(f"scenario.{name}" for name in scenario)]
        self._names = [f"{name}[{i}]" for name, size in sizes.items() for i in range(size)]
        self._ends = np.cumsum(list(sizes.values()))[:-1]

    def encode(self, message: Message) -> bytes:
        """As it goes over the wire. Its parts are these, in any order."""
        signal = lcmt_drake_signal()
        header = [message.phase, message.station, *self.scenario.values()]
        parts = [message.parts[name] for name in self.sizes]
        signal.val = [*map(float, header), *np.concatenate(parts).tolist()]
        signal.dim = len(signal.val)
        signal.coord = self._header + self._names
        signal.timestamp = round(1e6 * message.time)
        return signal.encode()

    def decode(self, data: bytes) -> Message | None:
        """What was told; None if it is anything but a message with this header and these parts."""
        try:
            signal = lcmt_drake_signal.decode(data)
        except (ValueError, struct.error, MemoryError):
            return None
        size = len(self._header)
        if signal.coord[:size] != self._header:
            return None
        phase, station, *numbers = signal.val[:size]
        if phase not in tuple(Phase) or not (station.is_integer() and 0 <= station < NUMBERS):
            return None
        told = zip(self.scenario.items(), numbers, strict=True)
        differing = tuple(name for (name, own), number in told if number != own)
        parts: dict[str, np.ndarray] = {}
        if not differing:
            if signal.coord[size:] != self._names:
                return None
            values = np.split(np.array(signal.val[size:]), self._ends)
            parts = dict(zip(self.sizes, values, strict=True))
        return Message(signal.timestamp / 1e6, Phase(int(phase)), int(station), parts, differing)
