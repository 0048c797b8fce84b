"""Flying a scenario: the closed loop, a Simulator, a monitor and logs."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, Multiplexer

from aerodrake.flight_log import PORTS, FlightLog, key_columns, rotate
from aerodrake.model.direction import make_direction
from aerodrake.model.kinematics import Kinematics
from aerodrake.model.reference import hover_then_follow, make_reference
from aerodrake.model.rotation import rotation_matrix
from aerodrake.model.setpoint import integrate
from aerodrake.model.vehicle import Vehicle
from aerodrake.model.vehicle_state import parts
from aerodrake.recording import Recording
from aerodrake.scenario import Scenario
from aerodrake.station import add_closed_loop, make_context
from aerodrake.threads import single_thread

MONITOR_PERIOD_S = 0.1
LOG_SAMPLES = 1000
"""Samples that are held in memory before they are moved to a file."""

LOST_TILT_RAD = math.radians(60)
LOST_ERROR_M = 1.0


class Flight:
    """A scenario's closed loop with logs on its ports, ready to fly.

    Attributes:
        scenario: What is flown.
        closed_loop: Its diagram: station, coordinator and log; out `true_state`.
        curve: Its reference.
    """

    def __init__(self, scenario: Scenario):
        self.scenario = scenario
        builder = DiagramBuilder()
        # Beside station and coordinator, since each diagram around them costs at every step.
        ports = add_closed_loop(builder, scenario)
        sizes = {name: ports[name].size() for name in PORTS}
        # Side by side in one sink: each sink would be an event of its own.
        samples = builder.AddNamedSystem("samples", Multiplexer(list(sizes.values())))
        for i, name in enumerate(PORTS):
            builder.Connect(ports[name], samples.get_input_port(i))
        self._sink = LogVectorOutput(
            samples.get_output_port(), builder, scenario.rates.flight_period_s
        )
        self._sink.set_name("log")
        self._columns = key_columns(sizes)
        first = self._columns["p_Bd_m"].start
        self._segment = slice(first, first + sizes["segment"])
        builder.ExportOutput(ports["true_state"], "true_state")
        self.closed_loop: Diagram = builder.Build()
        self.closed_loop.set_name("flight")
        coordinator = self.closed_loop.GetSubsystemByName("coordinator")
        self._controller = coordinator.GetSubsystemByName(scenario.controller)
        self._vehicle = Vehicle.load(scenario)
        self._kinematics = Kinematics(self._vehicle.robot)
        self.curve = make_reference(scenario.reference, self._vehicle.p_E)
        # What is compiled is loaded now, lest the first ticks wait for it.
        with single_thread():
            context = make_context(self.closed_loop, scenario.seed)
            Simulator(self.closed_loop, context).AdvanceTo(scenario.rates.mpc_period_s)

    def fly(self, progress: Callable[[float], None] = lambda simulated_s: None) -> FlightLog:
        """Flies from trim to the scenario's end, or until the vehicle is lost.

        Args:
            progress: Called with the simulated time in s as it advances.
        """
        scenario = self.scenario
        context = make_context(self.closed_loop, scenario.seed)
        simulator = Simulator(self.closed_loop, context)
        # Times are rounded, lest they land beyond a tick that is not to be flown.
        end = round(scenario.settle_s + scenario.duration, 9)
        self._controller.tick_ms.clear()
        monitor = _Monitor(self, context)
        recording = Recording(self._columns)
        reason, cause = "completed", ""
        start = time.perf_counter()
        with single_thread():
            try:
                for step in range(1, math.ceil(end / MONITOR_PERIOD_S - 1e-9) + 1):
                    simulator.AdvanceTo(min(round(step * MONITOR_PERIOD_S, 9), end))
                    self._record(recording, context, LOG_SAMPLES)
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
        self._record(recording, context)
        time_s = np.round(recording.times - scenario.settle_s, 9)
        recording.add(self._derived(time_s, recording))
        return FlightLog(recording, reason, cause, wall_s)

    def p_E(self, state: np.ndarray) -> np.ndarray:
        """(3,) m, the end-effector at a state (13 + 2 n,)."""
        quaternion, p_B, q, _, _, _ = parts(state)
        return p_B + rotation_matrix(quaternion) @ self._kinematics.tool(q)[0]

    def _record(self, recording: Recording, context: Context, least: int = 1) -> None:
        """Moves what the sink holds to the recording, if it is `least` samples or more."""
        log = self._sink.FindMutableLog(context)
        # What an interrupt kept from being cleared is there already.
        fresh = log.sample_times() > recording.end
        if np.count_nonzero(fresh) < least:
            return
        times, samples = log.sample_times()[fresh], log.data()[:, fresh]
        # Setpoints in the place of the polynomials that they follow.
        segment = samples[self._segment]
        m = len(segment) // 3
        p, v, u = segment[:-1].reshape(3, m, -1)
        segment[: 2 * m] = np.vstack(integrate(p, v, u, times - segment[-1]))
        recording.append(times, samples)
        log.Clear()

    def _derived(
        self, time_s: np.ndarray, signals: Mapping[str, np.ndarray]
    ) -> dict[str, np.ndarray]:
        """The keys of `DERIVED`, of which the loop knows nothing or which it need not evaluate."""
        quaternion = signals["quaternion"]
        p_EB, t_B = np.empty((2, len(time_s), 3))
        for i, q in enumerate(signals["q_rad"]):
            p_EB[i], t_B[i] = self._kinematics.tool(q)
        p_Ed, v_Ed = hover_then_follow(self.curve, self._vehicle.p_E, time_s)
        direction = make_direction(self.scenario.orientation)
        return {
            "time_s": time_s,
            "p_Ed_m": p_Ed,
            "v_Ed_m_s": v_Ed,
            "p_E_m": signals["p_B_m"] + rotate(quaternion, p_EB),
            "tool_axis": rotate(quaternion, t_B),
            "tool_axis_d": np.zeros_like(t_B)
            if direction is None
            else direction.evaluate(time_s)[0],
            "tick_ms": np.array(self._controller.tick_ms),
        }


class _Monitor:
    """Tells when the vehicle is lost. Its times are reference times."""

    def __init__(self, flight: Flight, context: Context):
        self._flight = flight
        self._context = context
        self._state = flight.closed_loop.GetOutputPort("true_state")
        self._start = flight.p_E(self._state.Eval(self._context))
        # A target that is far at first is to be approached before it can be left.
        distance = float(np.linalg.norm(self._target(0.0) - self._start))
        self._approached = distance <= flight.scenario.allocation.d_h_m
        self._farthest = LOST_ERROR_M + distance

    def time(self) -> float:
        """Reference time, s."""
        return self._context.get_time() - self._flight.scenario.settle_s

    def lost(self) -> str:
        """Why the vehicle is lost; empty if it is not."""
        x, t = self._state.Eval(self._context), self.time()
        when = f"at {t:.2f} s"
        if not np.isfinite(x).all():
            return f"the state is not finite {when}"
        upright = rotation_matrix(x[:4])[2, 2]
        tilt = math.acos(min(1.0, max(-1.0, upright)))
        if tilt > LOST_TILT_RAD:
            return f"tilt of {math.degrees(tilt):.0f} deg {when}"
        # Before reference time 0 it is to stay where it starts.
        is_hovering = t < 0
        target = self._start if is_hovering else self._target(t)
        error = math.dist(self._flight.p_E(x), target)
        self._approached |= error <= self._flight.scenario.allocation.d_h_m and not is_hovering
        if error > (LOST_ERROR_M if self._approached or is_hovering else self._farthest):
            return f"error of {error:.2f} m {when}"
        return ""

    def _target(self, t: float) -> np.ndarray:
        """(3,) m, where the end-effector is to be at a reference time >= 0."""
        return self._flight.curve.evaluate(np.array([t]))[0][0]
