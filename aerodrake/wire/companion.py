"""The coordinator as a companion computer runs it: to the clock of a station across the wire."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from pydrake.lcm import DrakeLcmInterface
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from aerodrake.coordinator import make_coordinator
from aerodrake.model.sensing.sample_check import MAX_MAGNITUDE, UNIT_LENGTH
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.station import make_context
from aerodrake.support.threads import single_thread
from aerodrake.support.tick_timer import TickTimer
from aerodrake.wire.link import Link
from aerodrake.wire.message import Message, Phase
from aerodrake.wire.remote_coordinator import make_layouts

PATIENCE_MS = 50
"""How long it waits for a message before it looks up."""

BEFORE = -1e-6
"""s: no flight has begun."""


@dataclass
class Service:
    """What a coordinator did for a station.

    Attributes:
        tick_ms: Wall time of forming and solving each program.
        answer_ms: Wall time from each tick's sample to its answer.
        missed: Ticks that did not have the sample of their instant.
        overruns: Ticks that were answered later than a period after.
        flown_s: How far the station's clock had come.
        fault: Why it ended before the station said so; empty if it did not.
    """

    tick_ms: list[float]
    answer_ms: list[float] = field(default_factory=list)
    missed: int = 0
    overruns: int = 0
    flown_s: float = 0.0
    fault: str = ""

    def line(self) -> str:
        """What a person is told of it."""
        if not self.answer_ms:
            return "no flight"
        median, p99 = np.percentile(self.answer_ms, [50, 99])
        return (
            f"{self.flown_s:.2f} s, {len(self.answer_ms)} ticks, {self.missed} missed, "
            f"{self.overruns} overruns; answered in {median:.1f} ms, "
            f"99 % within {p99:.1f} ms, {max(self.answer_ms):.1f} ms at most"
        )


class Companion:
    """A coordinator that is told samples, and tells setpoints.

    Its time is the station's: a sample takes it to the sample's time, and where that is a
    tick's, the answer goes out at once. Samples that do not come leave it where it is: their
    ticks are missed and never made up for, and what that means for the flight is the station's
    to say, which has a supervisor too. So when it was held up, it answers the first tick that
    comes. A station that is silent for as long as the supervisor lets a flight go
    on without attitude is dead. Of several stations it serves the first that it hears.

    Args:
        scenario: What the station flies.
        lcm: What messages go over.
        say: As `Link` has it.
    """

    def __init__(
        self,
        scenario: Scenario,
        lcm: DrakeLcmInterface,
        say: Callable[[str], None] = lambda note: None,
    ):
        self.scenario = scenario
        self._coordinator = make_coordinator(scenario)
        self.link = Link(lcm, *make_layouts(self._coordinator, scenario), False, say)
        self._controller = self._coordinator.GetSubsystemByName(scenario.controller)
        self._context = make_context(self._coordinator, scenario.seed)
        self._simulator = Simulator(self._coordinator, self._context)
        self._timer = TickTimer(self._controller)
        self.service = Service(self._timer.times_ms)
        self._timed = 0  # Ticks whose time has been told.
        self._time = -math.inf  # s, of the sample that was taken in last.
        # What is compiled is loaded now, lest the first ticks wait for it.
        warm = make_context(self._coordinator, scenario.seed)
        self._fix(warm, {"state": VehicleModel.load(scenario).trim_state})
        with single_thread():
            Simulator(self._coordinator, warm).AdvanceTo(scenario.rates.mpc_period_s)

    def serve(self, progress: Callable[[float], None]) -> Service:
        """Waits for a station and serves it until it says that its flight is over, or is dead.

        Args:
            progress: Called every 50 ms or more often, with the station's time in s; it may
                raise.

        Raises:
            BadInput: if the station that is there has another scenario.
        """
        heard = time.monotonic()
        lost_s = self.scenario.supervisor.attitude_lost_s
        with single_thread():
            while self.link.phase is not Phase.OVER:
                asked = time.monotonic()  # What came while this process was held up counts.
                if self.answer(PATIENCE_MS):
                    heard = time.monotonic()
                elif asked - heard > lost_s:
                    if self.link.phase is Phase.FLYING:
                        self.service.fault = (
                            f"no sample of the station for {lost_s:g} s, "
                            f"since {self.service.flown_s:.2f} s"
                        )
                        break
                    self.link.station = None  # It has gone before it flew: another one may come.
                progress(self.service.flown_s)
        return self.service

    def answer(self, patience_ms: int = 0) -> bool:
        """Takes in what came, and answers it; returns whether there was anything to take in.

        Args:
            patience_ms: How long to wait for it.

        Raises:
            BadInput: as `Link.hear`.
        """
        messages = self.link.hear(patience_ms)
        start = time.perf_counter()
        is_there = False
        for message in messages:
            if message.phase is Phase.WAITING and self.link.phase is Phase.WAITING:
                is_there = True
                self.link.tell(0.0, {})
            elif message.phase is Phase.FLYING and not self._is_believed(message):
                if message.time > self._time:  # Others are late, or were told twice.
                    self.link.refuse("samples come that no vehicle has, or of no time of a flight")
            elif message.phase is Phase.FLYING:
                is_there = True
                self._take_in(message)
                if self._is_tick(message.time):
                    self._tell(message.time)
                    took_s = time.perf_counter() - start
                    self.service.answer_ms.append(1e3 * took_s)
                    self.service.overruns += took_s > self.scenario.rates.mpc_period_s
            elif message.phase is Phase.OVER and self.link.phase is Phase.FLYING:
                self.link.phase = Phase.OVER
                self.link.tell(message.time, {})
        return is_there

    def _is_believed(self, message: Message) -> bool:
        """Whether a sample is new, and of a vehicle: what no filter passes, Drake dies of."""
        length = np.linalg.norm(message.parts["state"][:4])
        is_sane = all((np.abs(numbers) < MAX_MAGNITUDE).all() for numbers in message.parts.values())
        # Nobody is silent for so long and comes back.
        latest = self._time + self.scenario.supervisor.plan_lost_s
        is_next = self.link.phase is Phase.WAITING or message.time < latest
        is_new = is_next and max(self._time, BEFORE) < message.time < MAX_MAGNITUDE
        return is_sane and abs(length - 1) < UNIT_LENGTH and is_new

    def _take_in(self, message: Message) -> None:
        """Advances to a sample's time and makes all that is due there see it."""
        slack = self.scenario.rates.plant_step_s / 4
        begin = message.time - slack
        is_first = self.link.phase is Phase.WAITING
        if is_first:
            self.link.phase = Phase.FLYING
            self._timer.times_ms.clear()
        missed = 0 if is_first else self._ticks_between(self._time, message.time)
        self.service.missed += missed
        if missed or is_first and message.time > 0:
            # What is over is not worked off: it would take the time of the ticks to come.
            self._context.SetTime(begin)
            self._simulator.Initialize()
        elif not is_first:
            self._simulator.AdvanceTo(begin)
        self._fix(self._context, message.parts)
        self._simulator.AdvanceTo(message.time + slack)
        self._time = self.service.flown_s = message.time

    def _tell(self, tick: float) -> None:
        """Sends what the coordinator has to say after a tick."""
        told, took_ms = self.link.tells.sizes, self._timer.times_ms
        parts = {
            name: self._coordinator.GetOutputPort(name).Eval(self._context)[:size]
            for name, size in told.items()
            if name not in ("tick_ms", "output_time_s")
        }
        parts["output_time_s"] = np.array([self._context.get_time()])
        # A tick that is missed here, by fault, has no time either.
        parts["tick_ms"] = np.array(took_ms[self._timed :][-1:] or [np.nan])
        self._timed = len(took_ms)
        self.link.tell(tick, parts)

    def _fix(self, context: Context, parts: Mapping[str, np.ndarray]) -> None:
        """Puts numbers at the coordinator's inputs; at those that are not told, zeros."""
        for name, size in self.link.hears.sizes.items():
            self._coordinator.GetInputPort(name).FixValue(context, parts.get(name, np.zeros(size)))

    def _is_tick(self, time: float) -> bool:
        return self._ticks_between(time - 1e-6, time + 1e-6) == 1

    def _ticks_between(self, begin: float, end: float) -> int:
        """How many are due after `begin` and before `end`, in s."""
        period = self.scenario.rates.mpc_period_s
        return math.ceil((end - 1e-7) / period) - math.floor((begin + 1e-7) / period) - 1
