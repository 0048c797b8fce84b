"""Live view of a flight in Meshcat and in one line of text."""

import math
from collections.abc import Callable
from contextlib import ExitStack
from typing import Self

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, EventStatus

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.state import split_state
from aerodrake.reports.scene import Scene
from aerodrake.support.arguments import checked
from aerodrake.support.errors import BadInput
from aerodrake.support.limits import RATE

FRAMES_PER_S = 30.0
"""Frames per second of wall time."""
SHOWN_S = 120.0
"""Longest shown time span of the trace and of the reference."""
TRACE_EVERY = 3
"""Frames from one update of the trace to the next, which sends the whole path."""


class LiveView:
    """Shows a flight in Meshcat. It is a context manager, which closes the view.

    It does not change the flight.

    Attributes:
        rate: Simulated time over wall time of the flight; 1 is real time.

    Args:
        rate: The attribute, in the range of `RATE`.
        announce: Called with a line that has the address for a browser.

    Raises:
        BadInput: if the rate is out of range.
    """

    @checked
    def __init__(self, rate: float = 1.0, announce: Callable[[str], None] = print):
        slowest, fastest = RATE
        if not slowest <= rate <= fastest:
            expected = f"expected a number in [{slowest:g}, {fastest:g}]"
            raise BadInput("rate", "", f"{expected}, got {rate}")
        self.rate = rate
        self._announce = announce
        self._scenes = ExitStack()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._scenes.close()

    def attach(self, flight: FlightSimulation, simulator: Simulator) -> None:
        """Begins to show the flight; an argument of `FlightSimulation.fly`."""
        self._flight, self._scenario = flight, flight.scenario
        self._scene = self._scenes.enter_context(Scene(flight.scenario, flight.vehicle))
        self._announce(f"watch it at {self._scene.meshcat.web_url()}")
        self._context = simulator.get_context()
        self._coordinator = flight.closed_loop.GetSubsystemByName("coordinator")
        self._frames = self._viewers = 0
        self._trace: list[np.ndarray] = []
        self._draw_reference()
        self._show()
        simulator.set_monitor(self._monitor)

    def line(self) -> str:
        """Returns error, mode, gamma, and the supervisor's mode in one line."""
        state = self._flight.closed_loop.GetOutputPort("true_state").Eval(self._context)
        p_Ed = self._flight.closed_loop.GetOutputPort("reference").Eval(self._context)[:3]
        gamma, mode = self._port("weights")[:2]
        safe_mode = SafeMode(int(self._port("mode")[0]))
        error = math.dist(self._flight.p_E(state), p_Ed)
        return (
            f"error {1e3 * error:8.3f} mm  {Mode(int(mode)).label:<11}  gamma {gamma:+.2f}  "
            f"{safe_mode.label}"
        )

    def _monitor(self, context: Context) -> EventStatus:
        """Shows a frame if one is due; called at every step of the plant."""
        if context.get_time() * FRAMES_PER_S >= self._frames * self.rate:
            self._show()
        return EventStatus.DidNothing()

    def _show(self) -> None:
        state = self._flight.closed_loop.GetOutputPort("true_state").Eval(self._context)
        quaternion, p_B, q, *_ = split_state(state)
        self._scene.pose(self._context.get_time(), np.concatenate([quaternion, p_B, q]))
        self._scene.draw_learning_space()
        viewers = self._scene.meshcat.GetNumActiveConnections()
        if viewers > self._viewers:  # The camera of a new viewer is at the origin.
            self._scene.look_at(p_B)
        self._viewers = viewers
        if self._frames % TRACE_EVERY == 0:
            self._trace.append(self._flight.p_E(state))
            most = round(SHOWN_S * FRAMES_PER_S / TRACE_EVERY)
            self._scene.draw_trace(np.array(self._trace[-most:]))
            prediction = self._port("prediction").reshape(-1, 3)
            if prediction.any():  # Zero before the first tick.
                self._scene.draw_prediction(prediction)
        self._frames += 1

    def _draw_reference(self) -> None:
        time_s = np.arange(0.0, min(self._scenario.duration, SHOWN_S) + 1e-9, 0.02)
        curve = make_reference(self._scenario.reference, self._flight.vehicle.p_E)
        self._scene.draw_reference(curve.evaluate(time_s)[0])

    def _port(self, name: str) -> np.ndarray:
        """Evaluates an output of the coordinator."""
        context = self._coordinator.GetMyContextFromRoot(self._context)
        return self._coordinator.GetOutputPort(name).Eval(context)
