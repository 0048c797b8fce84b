"""When a flight is over, and why."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
from pydrake.systems.framework import Context, Diagram

from aerodrake.flight.not_finite import not_finite
from aerodrake.model.reference.envelope import JUMP_M
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.scenario import Scenario

MONITOR_PERIOD_S = 0.1
"""How often a flight is looked at."""

LOST_TILT_RAD = math.radians(60)
"""Tilt of the base beyond which a flight is lost,"""
LOST_ERROR_M = 1.0
"""and what is too far off its reference, or in safe modes off its setpoint."""


class Monitor:
    """Tells when a flight is over, and why. Its times are reference times.

    Args:
        scenario: What is flown.
        closed_loop: With the outputs that `Flight` exports.
        context: Of the closed loop.
        p_E: (3,) m, the end-effector at a state (13 + 2 n,).
    """

    def __init__(
        self,
        scenario: Scenario,
        closed_loop: Diagram,
        context: Context,
        p_E: Callable[[np.ndarray], np.ndarray],
    ):
        self._scenario = scenario
        self._closed_loop = closed_loop
        self._context = context
        self._p_E = p_E
        self._conditions = conditions(scenario.supervisor)
        self._target = self._eval("reference")[:3]
        self._begin_approach(p_E(self._eval("true_state")))

    def time(self) -> float:
        """Reference time, s."""
        return self._context.get_time() - self._scenario.settle_s

    def ended(self, in_time: bool = False) -> tuple[str, str]:
        """Why a flight is over, and what made it so; both are empty if it is not.

        A condition of the supervisor is told by its name, all else with its time.

        Args:
            in_time: Whether it is, since the scenario's time is flown.
        """
        if cause := self.lost():
            return "lost", cause
        mode = SafeMode(int(self._eval("mode")[0]))
        if mode is SafeMode.NOMINAL:
            return ("completed", "") if in_time else ("", "")
        condition = self._conditions[int(self._eval("cause")[0])]
        if mode is SafeMode.STOP:
            return condition.exit_reason, condition.name
        return (mode.label, condition.name) if in_time else ("", "")

    def lost(self) -> str:
        """Why the vehicle is lost; empty if it is not."""
        x, when = self._eval("true_state"), f"at {self.time():.2f} s"
        if not np.isfinite(x).all():
            return f"the state is not finite {when}"
        upright = rotation_matrix(x[:4])[2, 2]
        tilt = math.acos(min(1.0, max(-1.0, upright)))
        if tilt > LOST_TILT_RAD:
            return f"tilt of {math.degrees(tilt):.0f} deg {when}"
        reference, p_E = self._eval("reference"), self._p_E(x)
        moved = math.dist(reference[:3], self._target)
        self._target = reference[:3]
        has_jumped = moved > JUMP_M + MONITOR_PERIOD_S * np.linalg.norm(reference[3:])
        if self._eval("mode")[0] != SafeMode.NOMINAL:
            # It follows its setpoints then, not the reference.
            self._begin_approach(p_E)
            away = math.dist(x[4:7], self._eval("base_setpoint")[:3])
            return f"{away:.2f} m off its setpoint {when}" if away > LOST_ERROR_M else ""
        if has_jumped:
            self._begin_approach(p_E)
        error = math.dist(p_E, self._target)
        self._approached |= error <= self._scenario.allocation.d_h_m
        if error > (LOST_ERROR_M if self._approached else self._farthest):
            return f"error of {error:.2f} m {when}"
        return ""

    def broken(self, error: BaseException) -> str:
        """Why the vehicle is lost where a step could not be made; empty if that is a defect.

        The plant, for one, cannot step from or by what is not finite.

        Args:
            error: What the step ended by.
        """
        spoilt = ", ".join(not_finite(self._closed_loop, self._context))
        cause = f"{spoilt} not finite at {self.time():.2f} s" if spoilt else self.lost()
        said = re.sub(r"^Failure at \S+ in ", "", str(error)).partition("\n")[0]
        return f"{cause}; {said}" if cause else ""

    def _begin_approach(self, p_E: np.ndarray) -> None:
        """A target that is far at first is to be approached before it can be left."""
        self._approached = False
        self._farthest = LOST_ERROR_M + math.dist(self._target, p_E)

    def _eval(self, port: str) -> np.ndarray:
        return self._closed_loop.GetOutputPort(port).Eval(self._context).copy()
