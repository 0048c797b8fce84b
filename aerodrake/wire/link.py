"""Link between station and coordinator in processes of their own, over LCM.

    channel                 sender, when                  signals
    AERODRAKE_STATION       station, at every sample      station interface, followed segment
    AERODRAKE_COORDINATOR   coordinator, at every tick    segment, plan, and its logged outputs

`aerodrake.wire.message` describes the rest of a message. Times are the station's, in s from the
start of the flight in trim.

Each station draws a number; a coordinator serves the first station that it receives, and both
ignore messages with another number. If the scenarios of the two ends differ, no flight begins,
and both report the sections that differ.
"""

import secrets
from collections import deque
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.lcm import DrakeLcmInterface

from aerodrake.support.errors import BadInput
from aerodrake.wire.message import NUMBERS, Layout, Message, Phase

STATION, COORDINATOR = "AERODRAKE_STATION", "AERODRAKE_COORDINATOR"
"""Channels, by sender."""

BACKLOG = 100
"""Largest number of messages that are kept between two calls of `receive`, the newest."""

CLOSING_S = 0.5
"""s, time for which an end announces the end of the flight if the other does not confirm it."""


class Link:
    """One end of the link.

    Attributes:
        lcm: LCM interface.
        phase: Phase of this end, which its messages contain.
        station: Number of the station. At the coordinator's end that of the station it serves;
            None until the first message.
        outgoing, incoming: Layouts of the messages to and from the other end.
        rejected: Number of messages that were received but ignored.
        tick_ms: At the station's end, wall time of the coordinator's computation at each tick
            whose reply was accepted, if the coordinator reported one.

    Args:
        lcm: LCM interface, used by this end only.
        station: Layout of the station's messages.
        coordinator: Layout of the coordinator's messages.
        is_station: True for the station's end.
        notify: Called once for each problem with messages, with a line of text.
    """

    def __init__(
        self,
        lcm: DrakeLcmInterface,
        station: Layout,
        coordinator: Layout,
        is_station: bool,
        notify: Callable[[str], None] = lambda note: None,
    ):
        self.lcm = lcm
        self._notify = notify
        self._reported: set[str] = set()
        self.phase = Phase.WAITING
        self.rejected = 0
        self.tick_ms: list[float] = []
        self._is_station = is_station
        # Not from the scenario's seed: stations must differ. No result depends on it.
        self.station = secrets.randbelow(NUMBERS) if is_station else None
        layouts = (station, coordinator) if is_station else (coordinator, station)
        self.outgoing, self.incoming = layouts
        self._channel, other = (STATION, COORDINATOR) if is_station else (COORDINATOR, STATION)
        self._backlog: deque[bytes] = deque(maxlen=BACKLOG)
        lcm.Subscribe(other, self._backlog.append)

    def publish(self, time: float, signals: Mapping[str, np.ndarray]) -> None:
        """Sends a message; a coordinator must have a station.

        Args:
            time: s, as in `Message`.
            signals: (size,) values by name; signals that are not given are zero.
        """
        zeros = {name: np.zeros(size) for name, size in self.outgoing.sizes.items()}
        message = Message(time, self.phase, self.station, {**zeros, **signals})
        self.lcm.Publish(self._channel, self.outgoing.encode(message))

    def wait(self, check: Callable[[], None]) -> None:
        """Waits for the other end, and calls `check`, which may raise, every 0.1 s.

        Raises:
            BadInput: as `receive`.
        """
        self.phase = Phase.WAITING
        while not any(message.phase is Phase.WAITING for message in self.receive(100)):
            self.publish(0.0, {})
            check()

    def close(self, time: float) -> None:
        """Announces the end of the flight at `time` in s until the other end confirms it.

        It is repeated, since messages may be lost; after `CLOSING_S` the other end
        counts as dead.
        """
        self.phase = Phase.OVER
        for _ in range(round(CLOSING_S / 0.02)):
            self.publish(time, {})
            if (self.station, Phase.OVER) in [(m.station, m.phase) for m in self._decode(20)]:
                return

    def receive(self, timeout_ms: int = 0) -> list[Message]:
        """Returns the messages of the other end since the last call, oldest first.

        Args:
            timeout_ms: Time to wait for a message.

        Raises:
            BadInput: if this end waits, and the other end has another scenario. It is
                notified and raises as well.
        """
        messages = []
        for message in self._decode(timeout_ms):
            if self.station is None and message.phase is not Phase.OVER:
                self.station = message.station
            differing = ", ".join(message.differing)
            if message.station != self.station:
                self.reject(
                    "the coordinator serves another station"
                    if self._is_station
                    else "messages of another station are ignored"
                )
            elif not differing:
                messages.append(message)
            elif self.phase is Phase.WAITING:
                self.close(0.0)
                end = "coordinator" if self._is_station else "station"
                expected = f"expected a {end} of the same scenario"
                raise BadInput("lcm", "", f"{expected}, got one that differs in {differing}")
            else:
                self.reject(f"messages of another scenario are ignored; it differs in {differing}")
        return messages

    def _decode(self, timeout_ms: int) -> list[Message]:
        """Returns all messages of the channel, of any station."""
        self.lcm.HandleSubscriptions(timeout_ms)
        messages = []
        while self._backlog:
            message = self.incoming.decode(self._backlog.popleft())
            if message is None:
                self.reject("messages of another format or version are ignored")
            else:
                messages.append(message)
        return messages

    def reject(self, problem: str, got: str = "") -> None:
        """Counts a message that is ignored, and reports the problem."""
        self.rejected += 1
        self.report(problem, got)

    def report(self, problem: str, got: str = "") -> None:
        """Reports a problem when it first occurs, with what was got then."""
        if problem not in self._reported:
            self._reported.add(problem)
            self._notify(f"note: {problem}{got and f', got {got}'}")
