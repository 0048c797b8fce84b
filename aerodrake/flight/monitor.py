"""Detection of the end of a flight: completed, in a safe mode, or lost."""

import math
import re
from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, Diagram

from aerodrake.flight.not_finite import not_finite
from aerodrake.model.reference.envelope import JUMP_M
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Scenario
from aerodrake.support.errors import BadInput

MONITOR_PERIOD_S = 0.1
"""Simulated time between two checks of a flight."""

LOST_TILT_RAD = math.radians(60)
"""Tilt of the base beyond which the vehicle is lost."""
LOST_ERROR_M = 1.0
"""Distance from the reference, in safe modes from the setpoint, beyond which it is lost; the
distance by which resets have moved the estimated position is added."""
DIVERGED = 1e4
"""Absolute value of a state, in m, rad, m/s or rad/s, above which the simulation diverges; attitude
and distances overflow with larger ones."""

REFUSALS = (BadInput, OSError, MemoryError)
"""Errors of the machine or of the remote coordinator, which never mean a lost vehicle."""


class Monitor:
    """Detects the end of a flight and its cause, with reference times.

    Args:
        scenario: The scenario that is flown.
        closed_loop: A diagram with the outputs that `FlightSimulation` exports.
        context: Context of the closed loop.
        p_E: Function from a state (13 + 2 n,) to the end-effector (3,) m.
    """

    def __init__(
        self,
        scenario: Scenario,
        closed_loop: Diagram,
        context: Context,
        p_E: Callable[[np.ndarray], np.ndarray],
    ):
        self._scenario, self._closed_loop, self._context = scenario, closed_loop, context
        self._p_E = p_E
        self._conditions = conditions(scenario.supervisor)
        self._target, self._offset = self._eval("reference")[:3], np.zeros(3)
        self._begin_approach(p_E(self._eval("true_state")))

    def time(self) -> float:
        """Returns the reference time in s."""
        return self._context.get_time() - self._scenario.settle_s

    def ending(self, time_is_up: bool = False) -> tuple[str, str]:
        """Returns the exit reason and cause of the flight; both are empty if it continues.

        The cause is the name of a supervisor's condition, or a sentence with the time.

        Args:
            time_is_up: True at the scenario's end.
        """
        if cause := self.lost():
            return "lost", cause
        mode = SafeMode(int(self._eval("mode")[0]))
        if mode is SafeMode.NOMINAL:
            return ("completed", "") if time_is_up else ("", "")
        condition = self._conditions[int(self._eval("cause")[0])]
        if mode is SafeMode.STOP:
            return condition.exit_reason, condition.name
        return (mode.label, condition.name) if time_is_up else ("", "")

    def lost(self) -> str:
        """Returns the cause if the vehicle is lost; empty if it is not."""
        x, when = self._eval("true_state"), f"at {self.time():.2f} s"
        if not np.isfinite(x).all():
            return f"the state is not finite {when}"
        if np.abs(x).max() > DIVERGED:
            return f"the state diverges {when}"
        state = split_state(x)
        tilt = math.acos(np.clip(state.R_B[2, 2], -1.0, 1.0))
        if tilt > LOST_TILT_RAD:
            return f"tilt of {math.degrees(tilt):.0f} deg {when}"
        reference, p_E = self._eval("reference"), self._p_E(x)
        moved = math.dist(reference[:3], self._target)
        self._target = reference[:3]
        has_resets = self._closed_loop.HasOutputPort("position_offset")
        offset = self._eval("position_offset") if has_resets else np.zeros(3)
        has_jumped = moved > JUMP_M + MONITOR_PERIOD_S * np.linalg.norm(reference[3:])
        has_jumped |= not np.array_equal(offset, self._offset)
        self._offset, farthest = offset, LOST_ERROR_M + np.linalg.norm(offset)
        if self._eval("mode")[0] != SafeMode.NOMINAL:
            # Safe modes follow the setpoint, not the reference.
            self._begin_approach(p_E)
            away = math.dist(state.p_B, self._eval("base_setpoint")[:3])
            return f"base {away:.2f} m from its setpoint {when}" if away > farthest else ""
        if has_jumped:
            self._begin_approach(p_E)
        error = math.dist(p_E, self._target)
        self._approached |= error <= self._scenario.allocation.d_h_m
        if error > (farthest if self._approached else self._farthest):
            return f"error of {error:.2f} m {when}"
        return ""

    def cause_of_loss(self, error: BaseException) -> str:
        """Returns the cause if the vehicle is lost after a step that raised `error`.

        The plant cannot step with a state or input that is not finite, for example.

        Raises:
            BaseException: `error` itself, if the vehicle is not lost.
        """
        if isinstance(error, REFUSALS):
            raise error
        ports = ", ".join(not_finite(self._closed_loop, self._context))
        cause = f"{ports} not finite at {self.time():.2f} s" if ports else self.lost()
        if not cause:
            raise error
        message = re.sub(r"^Failure at \S+ in ", "", str(error)).partition("\n")[0]
        message = message.partition(". ")[0].removesuffix(".")
        return f"{cause}; {message}"

    def _begin_approach(self, p_E: np.ndarray) -> None:
        """Tolerates the distance to a new target until the end-effector is within d_h of it."""
        self._approached = False
        resets = np.linalg.norm(self._offset)
        self._farthest = LOST_ERROR_M + resets + math.dist(self._target, p_E)

    def _eval(self, port: str) -> np.ndarray:
        return self._closed_loop.GetOutputPort(port).Eval(self._context).copy()
