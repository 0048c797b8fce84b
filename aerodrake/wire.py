"""What station and coordinator tell each other over LCM, when each has a process of its own.

    channel                 from, when                    parts
    AERODRAKE_STATION       station, at every sample      `SEAM`, and the segment it follows
    AERODRAKE_COORDINATOR   coordinator, at every tick    segment, plan, and what is logged of it

Messages are Drake's `lcmt_drake_signal`: numbers, each with its name (`state[4]`), and a
time stamp. The time is the station's, in microseconds from where its flight begins, in trim.
The first number is a `Phase`.
"""

from __future__ import annotations

import ipaddress
import re
import struct
from collections import deque
from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from drake import lcmt_drake_signal
from pydrake.lcm import DrakeLcm, DrakeLcmInterface

from aerodrake.errors import BadInput

STATION, COORDINATOR = "AERODRAKE_STATION", "AERODRAKE_COORDINATOR"
"""Channels, by who sends."""

BACKLOG = 100
"""Messages that are taken in at one look; of more, the newest. Over UDP, LCM keeps one a channel
until somebody looks: the oldest."""

FAREWELL_S = 0.5
"""For so long an end says that the flight is over, until the other one has heard it."""


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
        parts: (size,) numbers by name. They may be no numbers, as those of a sensor.
    """

    time: float
    phase: Phase
    parts: dict[str, np.ndarray]


class Layout:
    """The parts of a channel's messages, in their order.

    Args:
        sizes: Of the parts, by name.
    """

    def __init__(self, sizes: Mapping[str, int]):
        self.sizes = dict(sizes)
        named = (f"{name}[{i}]" for name, size in sizes.items() for i in range(size))
        self._names = ["phase", *named]
        self._ends = np.cumsum(list(sizes.values()))[:-1]

    def encode(self, message: Message) -> bytes:
        """As it goes over the wire. Its parts are these, in any order."""
        signal = lcmt_drake_signal()
        parts = [message.parts[name] for name in self.sizes]
        signal.val = [float(message.phase), *np.concatenate(parts).tolist()]
        signal.dim = len(signal.val)
        signal.coord = self._names
        signal.timestamp = round(1e6 * message.time)
        return signal.encode()

    def decode(self, data: bytes) -> Message | None:
        """What was told; None if it is anything but a message of these parts."""
        try:
            signal = lcmt_drake_signal.decode(data)
        except (ValueError, struct.error, MemoryError):
            return None
        if signal.coord != self._names or signal.val[0] not in tuple(Phase):
            return None
        parts = np.split(np.array(signal.val[1:]), self._ends)
        return Message(
            signal.timestamp / 1e6,
            Phase(int(signal.val[0])),
            dict(zip(self.sizes, parts, strict=True)),
        )


class Link:
    """One end of the wire.

    Attributes:
        lcm: What it goes over.
        phase: Of this end, as the other is told.
        tells, hears: Layouts of its own messages, and of the other end's.
        refused: How many messages came that were none of those.

    Args:
        lcm: What it goes over; one of its own.
        station: Layout of the station's messages.
        coordinator: Layout of the coordinator's.
        is_station: Whose end it is.
        say: Is told, once, when messages come that are refused.
    """

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        station: Layout,
        coordinator: Layout,
        is_station: bool,
        say: Callable[[str], None] = lambda note: None,
    ):
        self.lcm = lcm
        self._say = say
        self.phase = Phase.WAITING
        self.refused = 0
        self.tells, self.hears = (station, coordinator) if is_station else (coordinator, station)
        self._to, of = (STATION, COORDINATOR) if is_station else (COORDINATOR, STATION)
        self._came: deque[bytes] = deque(maxlen=BACKLOG)
        lcm.Subscribe(of, self._came.append)

    def tell(self, time: float, parts: Mapping[str, np.ndarray]) -> None:
        """Sends a message of this end.

        Args:
            time: s, as in `Message`.
            parts: (size,) numbers by name; those that it does not have are zero.
        """
        zeros = {name: np.zeros(size) for name, size in self.tells.sizes.items()}
        message = Message(time, self.phase, {**zeros, **parts})
        self.lcm.Publish(self._to, self.tells.encode(message))

    def wait(self, check: Callable[[], None]) -> None:
        """Returns when the other end is there.

        Args:
            check: Called every 0.1 s; it may raise.
        """
        self.phase = Phase.WAITING
        while not any(message.phase is Phase.WAITING for message in self.hear(100)):
            self.tell(0.0, {})
            check()

    def part(self, time: float) -> None:
        """Says that the flight is over, at `time` in s, until the other end says the same.

        Whatever is lost on the way: for `FAREWELL_S` at most, since it may be dead.
        """
        self.phase = Phase.OVER
        for _ in range(round(FAREWELL_S / 0.02)):
            self.tell(time, {})
            if any(message.phase is Phase.OVER for message in self.hear(20)):
                return

    def hear(self, patience_ms: int = 0) -> list[Message]:
        """What the other end told since it was asked last, oldest first.

        Args:
            patience_ms: How long to wait for anything.
        """
        self.lcm.HandleSubscriptions(patience_ms)
        messages = []
        while self._came:
            message = self.hears.decode(self._came.popleft())
            if message is None:
                if not self.refused:
                    self._say("note: messages come of another robot or horizon, or not of ours")
                self.refused += 1
            else:
                messages.append(message)
        return messages


def make_lcm(url: str) -> DrakeLcm:
    """What messages go over.

    Args:
        url: As LCM has it, udpm://ADDRESS:PORT?ttl=N.

    Raises:
        BadInput: if it is none: LCM itself would go on without a wire.
    """
    match = re.fullmatch(r"udpm://([0-9.]+):(\d{1,5})(?:\?ttl=(\d{1,3}))?", url)
    try:
        address, port, ttl = match.groups(default="0")
        is_sound = ipaddress.IPv4Address(address).is_multicast
        is_sound = is_sound and 0 < int(port) < 65536 and int(ttl) < 256
    except (AttributeError, ValueError):
        is_sound = False
    if not is_sound:
        problem = f"expected udpm://ADDRESS:PORT?ttl=N with a multicast address, got {url!r}"
        raise BadInput("--lcm", "", problem)
    return DrakeLcm(url)
