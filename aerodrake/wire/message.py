"""Messages between station and coordinator: Drake's `lcmt_drake_signal`, numbers with names.

    name                 number
    phase                `Phase` of the sender
    station              number of the station that sends or is addressed
    scenario.rates, ...  hash of each section of the sender's scenario
    state[4], ...        elements of the signals, one signal after another

The first three rows are the header, which does not depend on the scenario. The time stamp is in
microseconds.
"""

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from drake import lcmt_drake_signal

NUMBERS = 2**48
"""Bound of whole numbers in a message: exact as floats, and unlikely to coincide by chance."""


class Phase(IntEnum):
    """Phase of the sender.

    WAITING: it waits for the other end, and its signals have no meaning. FLYING: it flies.
    OVER: the flight has ended.
    """

    WAITING = 0
    FLYING = 1
    OVER = 2


class Message(NamedTuple):
    """Message of a station or a coordinator.

    Attributes:
        time: s, time of the sample, or of the tick that the message replies to.
        phase: Phase of the sender.
        station: Number of the station that sends or is addressed.
        signals: (size,) values of each signal; they may be NaN or infinite, as of a sensor.
        differing: Sections in which the scenarios of sender and receiver differ. If there are
            any, the signals are not decoded.
    """

    time: float
    phase: Phase
    station: int
    signals: dict[str, np.ndarray]
    differing: tuple[str, ...] = ()


class Layout:
    """Layout of the messages of a channel.

    Args:
        scenario: Hash, below `NUMBERS`, of each section of the scenario on which both ends must
            agree, as from `fingerprint.coordinated`.
        sizes: Size of each signal.
    """

    def __init__(self, scenario: Mapping[str, int], sizes: Mapping[str, int]):
        self.scenario, self.sizes = dict(scenario), dict(sizes)
        self._header = ["phase", "station", *(f"scenario.{name}" for name in scenario)]
        self._names = [f"{name}[{i}]" for name, size in sizes.items() for i in range(size)]
        self._ends = np.cumsum(list(sizes.values()))[:-1]

    def encode(self, message: Message) -> bytes:
        """Returns the bytes of a message, whose signals are those of the layout, in any order."""
        signal = lcmt_drake_signal()
        header = [message.phase, message.station, *self.scenario.values()]
        values = [message.signals[name] for name in self.sizes]
        signal.val = [*map(float, header), *np.concatenate(values).tolist()]
        signal.dim = len(signal.val)
        signal.coord = self._header + self._names
        signal.timestamp = round(1e6 * message.time)
        return signal.encode()

    def decode(self, data: bytes) -> Message | None:
        """Returns the message; None if the data has another header or other signals."""
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
        sections = zip(self.scenario.items(), numbers, strict=True)
        differing = tuple(name for (name, own), number in sections if number != own)
        signals: dict[str, np.ndarray] = {}
        if not differing:
            if signal.coord[size:] != self._names:
                return None
            values = np.split(np.array(signal.val[size:]), self._ends)
            signals = dict(zip(self.sizes, values, strict=True))
        return Message(signal.timestamp / 1e6, Phase(int(phase)), int(station), signals, differing)
