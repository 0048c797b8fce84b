"""Flying a scenario: the closed loop, a Simulator, a monitor and logs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

from aerodrake.flight.log import PORTS, FlightLog, key_columns, rotate
from aerodrake.flight.monitor import MONITOR_PERIOD_S, Monitor
from aerodrake.flight.recording import Recording
from aerodrake.model.setpoint.integration import integrate, split_segment
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.station import add_closed_loop, make_context
from aerodrake.support.errors import BadInput
from aerodrake.support.threads import single_thread
from aerodrake.support.tick_timer import TickTimer
from aerodrake.wire.link import Link
from aerodrake.wire.message import Phase
from aerodrake.wire.remote_coordinator import make_remote_coordinator
from aerodrake.wiring.replacements import Replacements

LOG_SAMPLES = 1000
"""Samples that are held in memory before they are moved to a file."""

REFUSALS = (BadInput, OSError, MemoryError)
"""Of the machine, or of the other end of a wire: no fault of the flight's."""


class FlightSimulation:
    """A scenario's closed loop with logs on its ports, ready to fly.

    Attributes:
        scenario: What is flown.
        closed_loop: Its diagram: station, coordinator and log; out `true_state`, and of the
            coordinator `reference`, `base_setpoint`, `mode` and `cause`.
        vehicle: The vehicle that flies.

    Args:
        scenario: What is flown.
        replacements: Of systems of its diagram; None for none.
        link: The station's end of the wire to a coordinator elsewhere, if it is not here.
    """

    def __init__(
        self,
        scenario: Scenario,
        replacements: Replacements | None = None,
        link: Link | None = None,
    ):
        self.scenario = scenario
        self._link = link
        builder = DiagramBuilder()
        self.vehicle = VehicleModel.load(scenario)
        remote = make_remote_coordinator(scenario, self.vehicle, link) if link else None
        # Beside station and coordinator, since each diagram around them costs at every step.
        ports = add_closed_loop(builder, scenario, replacements, remote, self.vehicle)
        sizes = {name: ports[name].size() for name in PORTS if name in ports}
        # Side by side in one sink: each sink would be an event of its own.
        samples = builder.AddNamedSystem("samples", Multiplexer(list(sizes.values())))
        for i, name in enumerate(sizes):
            builder.Connect(ports[name], samples.get_input_port(i))
        self._sink = LogVectorOutput(
            samples.get_output_port(), builder, scenario.rates.flight_period_s
        )
        self._sink.set_name("log")
        self._columns = key_columns(sizes)
        first = self._columns["p_Bd_m"].start
        self._segment = slice(first, first + sizes["segment"])
        for name in ("true_state", "reference", "base_setpoint", "mode", "cause"):
            builder.ExportOutput(ports[name], name)
        self.closed_loop: Diagram = builder.Build()
        self.closed_loop.set_name("flight")
        self._tick_ms = link.tick_ms if link else _tick_ms(self.closed_loop, scenario.controller)
        self._kinematics = Kinematics(self.vehicle.plant)
        # What is compiled is loaded now, lest the first ticks wait for it.
        with single_thread():
            context = make_context(self.closed_loop, scenario.seed)
            try:
                Simulator(self.closed_loop, context).AdvanceTo(scenario.rates.mpc_period_s)
            except REFUSALS:
                raise
            except (Exception, SystemExit):
                pass  # What is wrong with the vehicle is so again in flight.

    def fly(
        self,
        progress: Callable[[float], None] = lambda simulated_s: None,
        rate: float = 0.0,
        attach: Callable[[FlightSimulation, Simulator], None] = lambda flight, simulator: None,
    ) -> FlightLog:
        """Flies from trim to the scenario's end, or until the vehicle is lost, or stops.

        With a coordinator elsewhere it waits in trim until that is there, and does not fly by
        one of another scenario.

        Args:
            progress: Called with the simulated time in s as it advances.
            rate: Of simulated over wall time, where the wall clock is to be followed; 0 for as
                fast as it can.
            attach: Called with the flight and its Simulator before that flies: for who
                watches it.

        Raises:
            BadInput: if the coordinator that is there has another scenario.
        """
        scenario = self.scenario
        context = make_context(self.closed_loop, scenario.seed)
        simulator = Simulator(self.closed_loop, context)
        attach(self, simulator)
        # Times are rounded, lest they land beyond a tick that is not to be flown.
        end = round(scenario.settle_s + scenario.duration, 9)
        self._tick_ms.clear()
        monitor = Monitor(scenario, self.closed_loop, context, self.p_E)
        recording = Recording(self._columns)
        reason = cause = ""
        if self._link:
            self._link.wait(lambda: progress(0.0))
            self._link.phase = Phase.FLYING
        simulator.set_target_realtime_rate(rate)
        start = time.perf_counter()
        with single_thread():
            try:
                for step in range(1, math.ceil(end / MONITOR_PERIOD_S - 1e-9) + 1):
                    simulator.AdvanceTo(min(round(step * MONITOR_PERIOD_S, 9), end))
                    self._record(recording, context, LOG_SAMPLES)
                    progress(context.get_time())
                    reason, cause = monitor.ended()
                    if reason:
                        self._log_end(recording, context)
                        break
                else:
                    reason, cause = monitor.ended(in_time=True)
            except KeyboardInterrupt:
                reason, cause = "interrupted", f"at {monitor.time():.2f} s"
            except REFUSALS:
                raise
            except (Exception, SystemExit) as error:  # Drake's conditions are the latter.
                reason, cause = "lost", monitor.broken(error)
                if not cause:
                    raise
            finally:
                if self._link:
                    self._link.close(context.get_time())
        wall_s = time.perf_counter() - start
        self._record(recording, context)
        time_s = np.round(recording.times - scenario.settle_s, 9)
        if cause in {condition.name for condition in conditions(scenario.supervisor)}:
            causes = recording["supervisor_cause"]
            others = np.flatnonzero(causes != causes[-1])
            cause += f" since {time_s[others[-1] + 1 if len(others) else 0]:.2f} s"
        recording.add(self._derived(time_s, recording))
        return FlightLog(recording, reason, cause, wall_s, self.vehicle)

    def p_E(self, state: np.ndarray) -> np.ndarray:
        """(3,) m, the end-effector at a state (13 + 2 n,)."""
        quaternion, p_B, q, _, _, _ = split_state(state)
        return p_B + rotation_matrix(quaternion) @ self._kinematics.tool(q)[0]

    def _log_end(self, recording: Recording, context: Context) -> None:
        """Logs the instant at which a flight was stopped, if the log has not come to it."""
        last = max(recording.end, *self._sink.FindLog(context).sample_times()[-1:], -np.inf)
        if last < context.get_time() - 1e-9:
            self.closed_loop.ForcedPublish(context)

    def _record(self, recording: Recording, context: Context, least: int = 1) -> None:
        """Moves what the sink holds to the recording, if it is `least` samples or more."""
        log = self._sink.FindMutableLog(context)
        # What an interrupt kept from being cleared is there already.
        fresh = log.sample_times() > recording.end
        if np.count_nonzero(fresh) < least:
            return
        times, samples = log.sample_times()[fresh], log.data()[:, fresh]
        recording.fill(samples)
        # Setpoints in the place of the polynomials that they follow.
        rows = samples[self._segment]
        p, v, u, tick_s = split_segment(rows)
        rows[: 2 * len(p)] = np.vstack(integrate(p, v, u, times - tick_s))
        recording.append(times, samples)
        log.Clear()

    def _derived(
        self, time_s: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """Returns the signals of `DERIVED`, and those of ports that the closed loop lacks."""
        quaternion = signals["quaternion"]
        p_EB, t_B = np.empty((2, len(time_s), 3))
        for i, q in enumerate(signals["q_rad"]):
            p_EB[i], t_B[i] = self._kinematics.tool(q)
        absent = {"tool_axis_d": np.zeros_like(t_B)} if "tool_axis_d" not in signals else {}
        return {
            "time_s": time_s,
            "p_E_m": signals["p_B_m"] + rotate(quaternion, p_EB),
            "tool_axis": rotate(quaternion, t_B),
            "tick_ms": np.array(self._tick_ms),
            **absent,
        }


def _tick_ms(closed_loop: Diagram, controller: str) -> list[float]:
    """Returns a list that each tick appends its wall time to, if the controller has that."""
    coordinator = closed_loop.GetSubsystemByName("coordinator")
    if not isinstance(coordinator, Diagram) or not coordinator.HasSubsystemNamed(controller):
        return []
    return TickTimer(coordinator.GetSubsystemByName(controller)).times_ms
