"""What station and coordinator tell each other over LCM, when each has a process of its own.

    channel                 from, when                    parts
    AERODRAKE_STATION       station, at every sample      its interface, and the segment it follows
    AERODRAKE_COORDINATOR   coordinator, at every tick    segment, plan, and what is logged of it

`wire_message` says what else is in each. Times are the station's, in s from where its flight
begins, in trim.

A station draws a number when it is made; a coordinator takes on that of the one it finds there,
and to others both are deaf. Ends of different scenarios do not begin a flight: both say in what
they differ.
"""

from __future__ import annotations

import ipaddress
import re
import secrets
from collections import deque
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.lcm import DrakeLcm, DrakeLcmInterface

from aerodrake.support.errors import BadInput
from aerodrake.wire.message import NUMBERS, Layout, Message, Phase

STATION, COORDINATOR = "AERODRAKE_STATION", "AERODRAKE_COORDINATOR"
"""Channels, by who sends."""

BACKLOG = 100
"""Messages that are taken in at one look; of more, the newest."""

FAREWELL_S = 0.5
"""For so long an end says that the flight is over, until the other one has heard it."""


class Link:
    """One end of the wire.

    Attributes:
        lcm: What it goes over.
        phase: Of this end, as the other is told.
        station: The station's number. At the coordinator's end, that of the one whose messages
            are heard, the first that is there; None until then.
        tells, hears: Layouts of its own messages, and of the other end's.
        refused: How many messages came that were not heard.
        tick_ms: At the station's end, wall time of the coordinator's computation at each tick
            whose answer was accepted, if the coordinator reported one.

    Args:
        lcm: What it goes over; one of its own.
        station: Layout of the station's messages.
        coordinator: Layout of the coordinator's.
        is_station: Whose end it is.
        say: Is told, once for each reason, when messages come that are refused.
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
        self._said: set[str] = set()
        self.phase = Phase.WAITING
        self.refused = 0
        self.tick_ms: list[float] = []
        self._is_station = is_station
        # Of a generator of its own: it is in no result.
        self.station = secrets.randbelow(NUMBERS) if is_station else None
        self.tells, self.hears = (station, coordinator) if is_station else (coordinator, station)
        self._to, of = (STATION, COORDINATOR) if is_station else (COORDINATOR, STATION)
        self._came: deque[bytes] = deque(maxlen=BACKLOG)
        lcm.Subscribe(of, self._came.append)

    def tell(self, time: float, parts: Mapping[str, np.ndarray]) -> None:
        """Sends a message of this end; that of a coordinator has a station.

        Args:
            time: s, as in `Message`.
            parts: (size,) numbers by name; those that it does not have are zero.
        """
        zeros = {name: np.zeros(size) for name, size in self.tells.sizes.items()}
        message = Message(time, self.phase, self.station, {**zeros, **parts})
        self.lcm.Publish(self._to, self.tells.encode(message))

    def wait(self, check: Callable[[], None]) -> None:
        """Returns when the other end is there.

        Args:
            check: Called every 0.1 s; it may raise.

        Raises:
            BadInput: as `hear`.
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
            own = (message for message in self._take(20) if message.station == self.station)
            if any(message.phase is Phase.OVER for message in own):
                return

    def hear(self, patience_ms: int = 0) -> list[Message]:
        """What the other end told since it was asked last, oldest first.

        Args:
            patience_ms: How long to wait for anything.

        Raises:
            BadInput: if this end waits, and the other one is there with another scenario. It
                was told so: it finds out as well.
        """
        messages = []
        for message in self._take(patience_ms):
            if self.station is None and message.phase is not Phase.OVER:
                self.station = message.station
            differing = ", ".join(message.differing)
            if message.station != self.station:
                self.refuse(
                    "the coordinator answers another station"
                    if self._is_station
                    else "another station is there, and is not answered"
                )
            elif not differing:
                messages.append(message)
            elif self.phase is Phase.WAITING:
                self.part(0.0)
                end = "coordinator" if self._is_station else "station"
                problem = (
                    f"expected a {end} of the same scenario, got one that differs in {differing}"
                )
                raise BadInput("--lcm", "", problem)
            else:
                self.refuse(f"messages come of another scenario, which differs in {differing}")
        return messages

    def _take(self, patience_ms: int) -> list[Message]:
        """All messages that came, whoever is meant."""
        self.lcm.HandleSubscriptions(patience_ms)
        messages = []
        while self._came:
            message = self.hears.decode(self._came.popleft())
            if message is None:
                self.refuse("messages come that are not of ours, or of another version")
            else:
                messages.append(message)
        return messages

    def refuse(self, reason: str) -> None:
        """Counts a message that is not heard; says why, once for each reason."""
        self.refused += 1
        if reason not in self._said:
            self._said.add(reason)
            self._say(f"note: {reason}")


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
