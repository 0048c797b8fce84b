"""The coordinator on a companion computer, which follows the clock of a station over the link."""

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
from aerodrake.support.tick_times import time_ticks
from aerodrake.wire.link import Link
from aerodrake.wire.message import Message, Phase
from aerodrake.wire.remote_coordinator import make_layouts
from aerodrake.wire.sample_clock import SampleClock

TIMEOUT_MS = 50
"""Longest wait for a message."""


@dataclass
class Service:
    """Statistics of the flight that a coordinator has served.

    Attributes:
        tick_ms: Wall time of forming and solving each program, or of each step of CLIK.
        reply_ms: Wall time from each tick's sample to its reply.
        missed: Ticks without the sample of their instant.
        overruns: Ticks whose reply took longer than a period.
        flown_s: Station's time at the last sample.
        fault: Reason to end before the flight; empty if there was none.
    """

    tick_ms: list[float]
    reply_ms: list[float] = field(default_factory=list)
    missed: int = 0
    overruns: int = 0
    flown_s: float = 0.0
    fault: str = ""

    def line(self) -> str:
        """Returns a line of text for a terminal."""
        if not self.reply_ms:
            return "no flight"
        median, p99 = np.percentile(self.reply_ms, [50, 99])
        return (
            f"{self.flown_s:.2f} s, {len(self.reply_ms)} ticks, {self.missed} missed, "
            f"{self.overruns} overruns; replies after {median:.1f} ms (median), "
            f"{p99:.1f} ms (99 %), {max(self.reply_ms):.1f} ms (max)"
        )


class Companion:
    """Coordinator that receives the samples of a station and replies with setpoints.

    Its time is the station's: it advances to the multiple of `rates.sensor_period_s` that is
    nearest to the time of each sample (`SampleClock`), and replies at once if that is the time of
    a tick. Ticks without a sample are missed and not computed later; the supervisor of the station
    handles them. A station that is silent for `supervisor.attitude_lost_s` counts as dead. Of
    several stations, the first one received is served.

    Args:
        scenario: Scenario of the station.
        lcm: LCM interface.
        notify: As for `Link`.
    """

    def __init__(
        self,
        scenario: Scenario,
        lcm: DrakeLcmInterface,
        notify: Callable[[str], None] = lambda note: None,
    ):
        self.scenario = scenario
        vehicle = VehicleModel.load(scenario)
        self._coordinator = make_coordinator(scenario, vehicle=vehicle)
        self.link = Link(lcm, *make_layouts(self._coordinator, scenario), False, notify)
        self._context = make_context(self._coordinator, scenario.seed)
        self._simulator = Simulator(self._coordinator, self._context)
        controller = self._coordinator.GetSubsystemByName(scenario.controller)
        self.service = Service(time_ticks(controller))
        self._reported = 0  # Number of times in `tick_ms` that were sent.
        rates = scenario.rates
        samples_per_tick = round(rates.mpc_period_s / rates.sensor_period_s)
        longest_gap = scenario.supervisor.plan_lost_s  # A longer one would have ended the flight.
        self._clock = SampleClock(rates.sensor_period_s, samples_per_tick, longest_gap)
        self._time = -math.inf  # s, assigned to the last sample.
        # Compiled code is loaded now, so that the first ticks do not wait for it.
        warm = make_context(self._coordinator, scenario.seed)
        self._fix_inputs(warm, {"state": vehicle.trim_state})
        with single_thread():
            Simulator(self._coordinator, warm).AdvanceTo(scenario.rates.mpc_period_s)

    def serve(self, progress: Callable[[float], None]) -> Service:
        """Serves a station until the end of its flight, or until it is dead.

        Args:
            progress: Called every 50 ms or more often, with the station's time in s; may raise.

        Raises:
            BadInput: if the station has another scenario.
        """
        received = time.monotonic()
        lost_s = self.scenario.supervisor.attitude_lost_s
        with single_thread():
            while self.link.phase is not Phase.OVER:
                polled = time.monotonic()  # Messages that arrived while this process paused count.
                if self.process_messages(TIMEOUT_MS):
                    received = time.monotonic()
                elif polled - received > lost_s:
                    if self.link.phase is Phase.FLYING:
                        self.service.fault = (
                            f"no sample from the station for {lost_s:g} s, "
                            f"since {self.service.flown_s:.2f} s"
                        )
                        break
                    self.link.station = None  # It ended before a flight: serve another one.
                progress(self.service.flown_s)
        return self.service

    def process_messages(self, timeout_ms: int = 0) -> bool:
        """Processes the received messages and replies; returns True if the station is alive.

        Raises:
            BadInput: as `Link.receive`.
        """
        messages = self.link.receive(timeout_ms)
        start = time.perf_counter()
        is_alive = False
        for message in messages:
            if message.phase is Phase.WAITING and self.link.phase is Phase.WAITING:
                is_alive = True
                self.link.publish(0.0, {})
            elif message.phase is Phase.FLYING:
                instant = self._assign(message)
                if instant is None:
                    continue
                is_alive = True
                self._advance_to(instant, message.signals)
                if self._ticks_between(instant - 1e-6, instant + 1e-6):
                    self._publish_reply(instant)
                    took_s = time.perf_counter() - start
                    self.service.reply_ms.append(1e3 * took_s)
                    self.service.overruns += took_s > self.scenario.rates.mpc_period_s
            elif message.phase is Phase.OVER and self.link.phase is Phase.FLYING:
                self.link.phase = Phase.OVER
                self.link.publish(message.time, {})
        return is_alive

    def _assign(self, message: Message) -> float | None:
        """Returns the time in s to advance to for a sample; None if the sample is not used."""
        if not self._has_valid_values(message):
            self.link.reject("samples with absurd values are ignored")
            return None
        assignment = self._clock.assign(message.time)
        if assignment.problem:
            report = self.link.reject if assignment.time is None else self.link.report
            report(assignment.problem, assignment.got)
        return assignment.time

    def _has_valid_values(self, message: Message) -> bool:
        """Returns True if the values of a sample can be those of a vehicle.

        The coordinator has no sample check: Drake raises on absurd values.
        """
        quaternion_error = abs(math.hypot(*message.signals["state"][:4]) - 1)
        is_bounded = (np.abs(np.concatenate([*message.signals.values()])) < MAX_MAGNITUDE).all()
        return is_bounded and quaternion_error < UNIT_LENGTH

    def _advance_to(self, instant: float, signals: Mapping[str, np.ndarray]) -> None:
        """Advances to a time in s; all events of that instant see the sample's signals."""
        slack = self.scenario.rates.plant_step_s / 4
        begin = instant - slack
        is_first = self.link.phase is Phase.WAITING
        if is_first:
            self.link.phase = Phase.FLYING
            self.service.tick_ms.clear()
        missed = 0 if is_first else self._ticks_between(self._time, instant)
        if missed:
            self.service.missed += missed
            self.link.report("ticks without a sample within half a sample period are missed")
        if missed or is_first and instant > 0:
            # Missed ticks are skipped: computing them would delay the next ones.
            self._context.SetTime(begin)
            self._simulator.Initialize()
        elif not is_first:
            self._simulator.AdvanceTo(begin)
        self._fix_inputs(self._context, signals)
        self._simulator.AdvanceTo(instant + slack)
        self._time = self.service.flown_s = instant

    def _publish_reply(self, tick: float) -> None:
        """Publishes the outputs of the coordinator after the tick at that time in s."""
        signals = {
            name: self._coordinator.GetOutputPort(name).Eval(self._context)[:size]
            for name, size in self.link.outgoing.sizes.items()
            if name not in ("tick_ms", "output_time_s")
        }
        signals["output_time_s"] = np.array([self._context.get_time()])
        # A tick that a fault makes the controller miss has no wall time.
        signals["tick_ms"] = np.array(self.service.tick_ms[self._reported :][-1:] or [np.nan])
        self._reported = len(self.service.tick_ms)
        self.link.publish(tick, signals)

    def _fix_inputs(self, context: Context, signals: Mapping[str, np.ndarray]) -> None:
        """Fixes the coordinator's inputs to signals; inputs without one are zero."""
        for name, size in self.link.incoming.sizes.items():
            value = signals.get(name, np.zeros(size))
            self._coordinator.GetInputPort(name).FixValue(context, value)

    def _ticks_between(self, begin: float, end: float) -> int:
        """Returns the number of ticks after `begin` and before `end`, in s."""
        period = self.scenario.rates.mpc_period_s
        return math.ceil((end - 1e-7) / period) - math.floor((begin + 1e-7) / period) - 1
