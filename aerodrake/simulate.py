"""Flying a scenario: the closed loop, a Simulator, a monitor and logs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, VectorLogSink

from aerodrake.flight_log import PORTS, FlightLog, split_port
from aerodrake.model.direction import make_direction
from aerodrake.model.kinematics import Kinematics
from aerodrake.model.reference import make_reference
from aerodrake.model.vehicle_state import VehicleState
from aerodrake.scenario import Scenario
from aerodrake.station import make_closed_loop, make_context
from aerodrake.threads import single_thread

MONITOR_PERIOD_S = 0.1
LOST_TILT_RAD = math.radians(60)
LOST_ERROR_M = 1.0


class Flight:
    """A scenario's closed loop with logs on its ports, ready to fly.

    Attributes:
        scenario: What is flown.
        closed_loop: Its diagram.
    """

    def __init__(self, scenario: Scenario):
        self.scenario = scenario
        builder = DiagramBuilder()
        self.closed_loop: Diagram = builder.AddSystem(make_closed_loop(scenario))
        self._sinks: dict[str, VectorLogSink] = {}
        for port in PORTS:
            sink = LogVectorOutput(
                self.closed_loop.GetOutputPort(port), builder, scenario.rates.flight_period_s
            )
            sink.set_name(f"{port}_log")
            self._sinks[port] = sink
        self._diagram = builder.Build()
        self._diagram.set_name("flight")
        coordinator = self.closed_loop.GetSubsystemByName("coordinator")
        self._controller = coordinator.GetSubsystemByName(scenario.controller)
        self._kinematics = Kinematics(scenario.vehicle.robot)

    def fly(self, progress: Callable[[float], None] = lambda simulated_s: None) -> FlightLog:
        """Flies from trim to the scenario's end, or until the vehicle is lost.

        Args:
            progress: Called with the simulated time in s as it advances.
        """
        scenario = self.scenario
        context = make_context(self._diagram, scenario.seed)
        simulator = Simulator(self._diagram, context)
        # Times are rounded, lest they land beyond a tick that is not to be flown.
        end = round(scenario.settle_s + scenario.duration, 9)
        self._controller.tick_ms.clear()
        monitor = _Monitor(self, context)
        reason, cause = "completed", ""
        start = time.perf_counter()
        with single_thread():
            try:
                for step in range(1, math.ceil(end / MONITOR_PERIOD_S - 1e-9) + 1):
                    simulator.AdvanceTo(min(round(step * MONITOR_PERIOD_S, 9), end))
                    progress(context.get_time())
                    cause = monitor.lost()
                    if cause:
                        reason = "lost"
                        break
            except KeyboardInterrupt:
                reason, cause = "interrupted", f"at {monitor.time():.2f} s"
            except RuntimeError as error:
                # The plant cannot step from a state that is not finite.
                cause = monitor.lost()
                if not cause:
                    raise
                reason, cause = "lost", f"{cause}; {error}".splitlines()[0]
        wall_s = time.perf_counter() - start
        return FlightLog(self._signals(context), reason, cause, wall_s)

    def tool_axis(self, state: np.ndarray) -> np.ndarray:
        """(3,), the direction in which the tool points at a state (13 + 2 n,)."""
        return self._kinematics.tool_axis(VehicleState.from_vector(state)).value

    def p_E(self, state: np.ndarray) -> np.ndarray:
        """(3,) m, the end-effector at a state (13 + 2 n,)."""
        return self._kinematics.end_effector(VehicleState.from_vector(state)).p_E

    def _signals(self, context: Context) -> dict[str, np.ndarray]:
        signals: dict[str, np.ndarray] = {}
        states = np.empty((0, 0))
        for port, sink in self._sinks.items():
            log = sink.FindLog(context)
            rows = log.data().T
            signals.update(split_port(port, rows))
            if port == "true_state":
                states = rows
                signals["time_s"] = np.round(log.sample_times() - self.scenario.settle_s, 9)
        signals["p_E_m"] = np.array([self.p_E(state) for state in states])
        signals["tool_axis"] = np.array([self.tool_axis(state) for state in states])
        direction = make_direction(self.scenario.orientation)
        signals["tool_axis_d"] = (
            np.zeros_like(signals["tool_axis"])
            if direction is None
            else direction.evaluate(signals["time_s"])[0]
        )
        signals["tick_ms"] = np.array(self._controller.tick_ms)
        return signals


class _Monitor:
    """Tells when the vehicle is lost. Its times are reference times."""

    def __init__(self, flight: Flight, context: Context):
        self._flight = flight
        self._context = flight.closed_loop.GetMyContextFromRoot(context)
        self._start = flight.p_E(self._output("true_state"))
        # A target that is far at first is to be approached before it can be left.
        target = make_reference(flight.scenario.reference, self._start).evaluate(np.zeros(1))[0][0]
        distance = float(np.linalg.norm(target - self._start))
        self._approached = distance <= flight.scenario.allocation.d_h_m
        self._farthest = LOST_ERROR_M + distance

    def time(self) -> float:
        """Reference time, s."""
        return self._context.get_time() - self._flight.scenario.settle_s

    def lost(self) -> str:
        """Why the vehicle is lost; empty if it is not."""
        x, when = self._output("true_state"), f"at {self.time():.2f} s"
        if not np.isfinite(x).all():
            return f"the state is not finite {when}"
        tilt = math.acos(min(1.0, max(-1.0, VehicleState.from_vector(x).R_B[2, 2])))
        if tilt > LOST_TILT_RAD:
            return f"tilt of {math.degrees(tilt):.0f} deg {when}"
        # Before reference time 0 it is to stay where it starts.
        is_hovering = self.time() < 0
        target = self._start if is_hovering else self._output("reference")[:3]
        error = float(np.linalg.norm(self._flight.p_E(x) - target))
        self._approached |= error <= self._flight.scenario.allocation.d_h_m and not is_hovering
        if error > (LOST_ERROR_M if self._approached or is_hovering else self._farthest):
            return f"error of {error:.2f} m {when}"
        return ""

    def _output(self, port: str) -> np.ndarray:
        return self._flight.closed_loop.GetOutputPort(port).Eval(self._context)
