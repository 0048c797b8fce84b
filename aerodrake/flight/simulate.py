"""Simulates a scenario's closed loop, with a monitor and a log."""

import math
import time
from collections.abc import Callable, Mapping
from typing import Self

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

from aerodrake.flight.log import PORTS, FlightLog, key_columns, rotate
from aerodrake.flight.monitor import MONITOR_PERIOD_S, Monitor
from aerodrake.flight.recording import Recording
from aerodrake.model.equivalent.model import EquivalentModel
from aerodrake.model.setpoint.integration import integrate, split_segment
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.state import split_state
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario
from aerodrake.station import add_closed_loop, make_context
from aerodrake.support.arguments import checked
from aerodrake.support.threads import single_thread
from aerodrake.support.tick_times import time_ticks
from aerodrake.wire.link import Link
from aerodrake.wire.message import Phase
from aerodrake.wire.remote_coordinator import make_remote_coordinator
from aerodrake.wiring.replacements import Replacements

MONITORED = ("true_state", "position_offset", "reference", "base_setpoint", "mode", "cause")
"""Outputs of station and coordinator that the monitor of a flight reads."""

LOG_SAMPLES = 1000
"""Number of samples in memory at which they are moved to a file."""


class FlightSimulation:
    """A scenario's closed loop with a log of its ports, ready to fly.

    Attributes:
        scenario: The scenario to fly.
        vehicle: Its vehicle.
        closed_loop: Diagram of station, coordinator and log. Its outputs are `MONITORED`.

    Args:
        scenario: The scenario to fly.
        replacements: Replacements of systems in the closed loop; None for none.
        link: The station's end of the link to a remote coordinator; None for a local one.

    Raises:
        BadInput: if the scenario cannot be flown, or a replacement does not fit.
    """

    @checked
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
        self._kinematics = Kinematics(self.vehicle.plant)
        remote = make_remote_coordinator(scenario, self.vehicle, link) if link else None
        # Without a diagram around both: each level of diagrams costs time at every step.
        ports = add_closed_loop(builder, scenario, replacements, remote, self.vehicle)
        sizes = {name: ports[name].size() for name in PORTS if name in ports}
        # One sink for all ports: each sink is an event of its own.
        samples = builder.AddNamedSystem("samples", Multiplexer(list(sizes.values())))
        for i, name in enumerate(sizes):
            builder.Connect(ports[name], samples.get_input_port(i))
        self._sink = LogVectorOutput(
            samples.get_output_port(), builder, scenario.rates.flight_period_s
        )
        self._sink.set_name("log")
        residual = EquivalentModel.of(scenario, self.vehicle.joints).residual
        self._columns = key_columns(sizes, residual.log_key)
        first = self._columns["p_Bd_m"].start
        self._segment = slice(first, first + sizes["segment"])
        for name in MONITORED:
            if name in ports:  # A replacement may lack some.
                builder.ExportOutput(ports[name], name)
        self.closed_loop: Diagram = builder.Build()
        self.closed_loop.set_name("flight")
        self._tick_ms = link.tick_ms if link else _tick_ms(self.closed_loop, scenario.controller)
        self._load_compiled_code()

    def fly(
        self,
        progress: Callable[[float], None] = lambda simulated_s: None,
        rate: float = 0.0,
        attach: Callable[[Self, Simulator], None] = lambda flight, simulator: None,
    ) -> FlightLog:
        """Flies from trim to the scenario's end, or until the vehicle is lost or stops.

        With a remote coordinator the flight begins when it is connected.

        Args:
            progress: Called with the simulated time in s as it advances.
            rate: Simulated time over wall time, to follow the wall clock; 0 for full speed.
            attach: Called with the flight and its Simulator before the flight begins, for
                observers.

        Raises:
            BadInput: if the connected coordinator has another scenario, or the log cannot be
                written.
        """
        context = make_context(self.closed_loop, self.scenario.seed)
        simulator = Simulator(self.closed_loop, context)
        attach(self, simulator)
        self._tick_ms.clear()
        monitor = Monitor(self.scenario, self.closed_loop, context, self.p_E)
        recording = Recording(self._columns)
        if self._link:
            self._link.wait(lambda: progress(0.0))
            self._link.phase = Phase.FLYING
        simulator.set_target_realtime_rate(rate)
        start = time.perf_counter()
        # The monitor ends a flight whose state is not finite.
        with single_thread(), np.errstate(over="ignore", invalid="ignore"):
            try:
                reason, cause = self._advance(simulator, monitor, recording, progress)
            except KeyboardInterrupt:
                reason, cause = "interrupted", f"at {monitor.time():.2f} s"
            except (Exception, SystemExit) as error:  # Drake raises SystemExit if a check fails.
                reason, cause = "lost", monitor.cause_of_loss(error)
            finally:
                if self._link:
                    self._link.close(context.get_time())
        wall_s = time.perf_counter() - start
        self._record(recording, context)
        time_s = np.round(recording.times - self.scenario.settle_s, 9)
        if cause in {condition.name for condition in conditions(self.scenario.supervisor)}:
            causes = recording["supervisor_cause"]
            others = np.flatnonzero(causes != causes[-1])
            cause += f" since {time_s[others[-1] + 1 if len(others) else 0]:.2f} s"
        recording.add(self._derived(time_s, recording))
        return FlightLog(recording, reason, cause, wall_s, self.vehicle)

    def p_E(self, state: np.ndarray) -> np.ndarray:
        """Returns (3,) m, the end-effector at a state (13 + 2 n,)."""
        quaternion, p_B, q, _, _, _ = split_state(state)
        return p_B + rotation_matrix(quaternion) @ self._kinematics.tool(q)[0]

    def _load_compiled_code(self) -> None:
        """Simulates one tick of the MPC, so that the first ticks of a flight do not wait.

        Raises the errors of the closed loop, except those of a lost vehicle, which `fly` reports.
        """
        with single_thread():
            context = make_context(self.closed_loop, self.scenario.seed)
            monitor = Monitor(self.scenario, self.closed_loop, context, self.p_E)
            try:
                Simulator(self.closed_loop, context).AdvanceTo(self.scenario.rates.mpc_period_s)
            except (Exception, SystemExit) as error:
                monitor.cause_of_loss(error)

    def _advance(
        self,
        simulator: Simulator,
        monitor: Monitor,
        recording: Recording,
        progress: Callable[[float], None],
    ) -> tuple[str, str]:
        """Simulates the flight; returns the exit reason and cause."""
        context = simulator.get_mutable_context()
        # Rounded, so that rounding errors add no tick at the end.
        end = round(self.scenario.settle_s + self.scenario.duration, 9)
        for step in range(1, math.ceil(end / MONITOR_PERIOD_S - 1e-9) + 1):
            simulator.AdvanceTo(min(round(step * MONITOR_PERIOD_S, 9), end))
            self._record(recording, context, LOG_SAMPLES)
            progress(context.get_time())
            reason, cause = monitor.ending()
            if reason:
                self._log_end(recording, context)
                return reason, cause
        return monitor.ending(time_is_up=True)

    def _log_end(self, recording: Recording, context: Context) -> None:
        """Logs the last instant of a flight that ended between two samples."""
        last = max(recording.end, *self._sink.FindLog(context).sample_times()[-1:], -np.inf)
        if last < context.get_time() - 1e-9:
            self.closed_loop.ForcedPublish(context)

    def _record(self, recording: Recording, context: Context, least: int = 1) -> None:
        """Moves the samples from the sink to the recording, if there are `least` or more."""
        log = self._sink.FindMutableLog(context)
        # After an interrupt the sink may still have samples that the recording has, too.
        is_new = log.sample_times() > recording.end
        if np.count_nonzero(is_new) < least:
            return
        times, samples = log.sample_times()[is_new], log.data()[:, is_new]
        recording.fill(samples)
        # Setpoints replace the polynomials.
        rows = samples[self._segment]
        p, v, u, tick_s = split_segment(rows)
        rows[: 2 * len(p)] = np.vstack(integrate(p, v, u, times - tick_s))
        recording.append(times, samples)
        log.Clear()

    def _derived(
        self, time_s: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """Returns the signals of `DERIVED`, and those of ports that the closed loop lacks.

        They are zeros, and the followed reference for the one that was asked for.
        """
        quaternion = signals["quaternion"]
        tool = np.array([self._kinematics.tool(q) for q in signals["q_rad"]])
        p_EB, t_B = tool[:, 0], tool[:, 1]
        absent = dict.fromkeys(
            ("tool_axis_d", "position_offset_m", "wind_force_n"), np.zeros_like(t_B)
        )
        joints = "torque_at_limit", "joint_oscillation_rad_s"
        absent |= dict.fromkeys(joints, np.zeros_like(signals["q_rad"]))
        if "p_Ed_m" not in signals:
            absent |= {key: signals[f"followed_{key}"] for key in ("p_Ed_m", "v_Ed_m_s")}
        absent = {key: rows for key, rows in absent.items() if key not in signals}
        return {
            "time_s": time_s,
            "p_E_m": signals["p_B_m"] + rotate(quaternion, p_EB),
            "tool_axis": rotate(quaternion, t_B),
            "tick_ms": np.array(self._tick_ms),
            **absent,
        }


def _tick_ms(closed_loop: Diagram, controller: str) -> list[float]:
    """Returns the wall times in ms of a controller's ticks; empty if the coordinator lacks it."""
    coordinator = closed_loop.GetSubsystemByName("coordinator")
    if not isinstance(coordinator, Diagram) or not coordinator.HasSubsystemNamed(controller):
        return []
    return time_ticks(coordinator.GetSubsystemByName(controller))
