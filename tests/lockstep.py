"""Link in memory: station and coordinator in one process with one clock, repeatable."""

from __future__ import annotations

from collections.abc import Callable

from pydrake.lcm import DrakeLcm

from aerodrake.flight.log import FlightLog
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.scenario import Scenario
from aerodrake.wire.companion import Companion
from aerodrake.wire.link import COORDINATOR
from aerodrake.wire.remote_coordinator import make_station_link


class Lockstep:
    """LCM interface of a station, which polls it each plant step; then the companion runs.

    Args:
        late: Number of polls from a reply until it arrives.
        is_lost: Returns True if the i-th message of a channel is lost.
    """

    def __init__(
        self, late: int = 0, is_lost: Callable[[str, int], bool] = lambda channel, i: False
    ):
        self.companion: Companion | None = None
        self._lcm = DrakeLcm("memq://")
        self._late, self.is_lost = late, is_lost
        self._polls = 0
        self._sent: dict[str, int] = {}
        self._delayed: list[tuple[int, bytes]] = []
        self._is_busy = False

    def Subscribe(self, channel, handler):
        return self._lcm.Subscribe(channel, handler)

    def Publish(self, channel, buffer):
        i = self._sent[channel] = self._sent.get(channel, -1) + 1
        if self.is_lost(channel, i):
            return
        if channel == COORDINATOR:
            self._delayed.append((self._polls + self._late, buffer))
        else:
            self._lcm.Publish(channel, buffer)

    def HandleSubscriptions(self, timeout_millis):
        if not self._is_busy:
            self._polls += 1
            if self.companion is not None:
                self._is_busy = True
                self.companion.process_messages()
                self._is_busy = False
            while self._delayed and self._delayed[0][0] <= self._polls:
                self._lcm.Publish(COORDINATOR, self._delayed.pop(0)[1])
        return self._lcm.HandleSubscriptions(0)


def fly_over(lcm: Lockstep, scenario: Scenario) -> FlightLog:
    """Flies with both ends in this process, faster than real time."""
    flight = FlightSimulation(scenario, link=make_station_link(scenario, lcm))
    lcm.companion = Companion(scenario, lcm)
    return flight.fly()
