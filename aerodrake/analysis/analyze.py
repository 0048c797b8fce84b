"""Analysis of a scenario's closed loop."""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from aerodrake.analysis.analysis import Analysis, OperatingPoint
from aerodrake.analysis.linear_loop import LinearLoop
from aerodrake.analysis.linearization import Linearizer, PeriodJacobian
from aerodrake.analysis.margin_limits import stability_margins
from aerodrake.analysis.modes import find_modes
from aerodrake.analysis.quiet_loop import QuietLoop
from aerodrake.analysis.saturation import saturated
from aerodrake.analysis.tool_responses import frequency_responses, step_responses
from aerodrake.flight.monitor import MONITOR_PERIOD_S, Monitor
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.model.vehicle.state import split_state
from aerodrake.scenario import Scenario
from aerodrake.support.threads import single_thread

HOVER_STEPS = 3
"""Number of steps of an analysis before those at times along the path."""

SETTLE_S = 12.0
"""s, longest hover before it is linearised; it ends earlier if the vehicle is at rest."""

CHECK_S = 0.5
"""s between two checks for rest: observers, filters and gates settle as well."""

SHORT_SETTLE_S = 0.1
"""s of hover before a loop is linearised that does not come to rest."""

AT_REST, RUNAWAY = 0.02, 3.0
"""Largest velocities of base and joints, in m/s and rad/s, at rest, and in hover."""

IN_MOTION = 6.0
"""m/s and rad/s, bound of the velocities of a hover that does not come to rest."""


def analyze_hover(scenario: Scenario) -> OperatingPoint:
    """Returns the sampled closed loop of a scenario in hover, without margins and responses.

    Raises:
        BadInput: if the scenario cannot be flown.
    """
    with single_thread():
        return _hover(_quiet_loop(scenario))[1]


def analyze_loop(
    scenario: Scenario,
    times: Sequence[float] = (),
    progress: Callable[[str], None] = lambda step: None,
) -> Analysis:
    """Analyses the sampled closed loop of a scenario in hover and along its path.

    The loop is linearised without noise and gusts, and with the unconstrained MPC;
    `QuietLoop` has all differences from the scenario's flight.

    Args:
        scenario: The scenario to analyse.
        times: s, reference times in [0, `duration`] at which to linearise along the path, in any
            order.
        progress: Called with the name of each step as it begins.

    Raises:
        BadInput: if the scenario cannot be flown.
    """
    with single_thread():
        progress("hover")
        quiet = _quiet_loop(scenario)
        loop, hover = _hover(quiet)
        progress("margins")
        margins = stability_margins(loop)
        progress("responses")
        steps, frequencies = step_responses(loop.system), frequency_responses(loop.system)
        path, ended = _path(quiet, sorted({*map(float, times)}), progress)
    return Analysis(scenario.name, hover, margins, steps, frequencies, path, ended)


def _quiet_loop(scenario: Scenario) -> QuietLoop:
    """Returns the loop in trim; the MPC does not foresee the reference's start while it settles."""
    span_s = scenario.mpc.span_ticks * scenario.rates.mpc_period_s
    with np.errstate(over="ignore", invalid="ignore"):
        return QuietLoop(scenario, SETTLE_S + span_s + scenario.rates.mpc_period_s)


def _hover(quiet: QuietLoop) -> tuple[LinearLoop, OperatingPoint]:
    """Linearises the loop where it comes to rest, or soon after trim if it does not."""
    is_settled = _comes_to_rest(quiet)
    if not is_settled:
        quiet.reset()
        quiet.advance(_after(quiet, SHORT_SETTLE_S))
        is_settled = quiet.fastest() < AT_REST  # An unstable loop rests in trim.
    period = _linearized(quiet)
    if not is_settled:
        period = replace(period, fastest=IN_MOTION)
    loop = LinearLoop(period)
    return loop, replace(_point(quiet, loop, None), is_settled=is_settled)


def _comes_to_rest(quiet: QuietLoop) -> bool:
    """Simulates from trim until the vehicle rests; returns False if it does not."""
    for end_s in np.arange(CHECK_S, SETTLE_S + CHECK_S / 2, CHECK_S):
        end_s = _after(quiet, end_s)
        try:
            with np.errstate(over="ignore", invalid="ignore"):
                quiet.advance(end_s)
                fastest = quiet.fastest()
        except (Exception, SystemExit):  # Drake raises SystemExit if a check fails.
            return False
        is_nominal = quiet.output("mode")[0] == SafeMode.NOMINAL
        if not (is_nominal and fastest < RUNAWAY and math.isclose(quiet.context.get_time(), end_s)):
            return False
        if fastest < AT_REST:
            return True
    return False


def _after(quiet: QuietLoop, settle_s: float) -> float:
    """Returns the start of the period that is nearest to a time, and not the first one."""
    return quiet.start_s(max(1, quiet.multiple(settle_s)))


def _linearized(quiet: QuietLoop) -> PeriodJacobian:
    """Linearises the period that begins now, with the unconstrained MPC."""
    quiet.is_constrained = False
    try:
        return Linearizer(quiet, quiet.multiple(quiet.context.get_time())).run()
    finally:
        quiet.is_constrained = True


def _point(quiet: QuietLoop, loop: LinearLoop, time_s: float | None) -> OperatingPoint:
    """Returns the operating point of a period that has just been linearised."""
    return OperatingPoint(time_s, loop.system, find_modes(loop), saturated(quiet))


def _path(
    quiet: QuietLoop, times: Sequence[float], progress: Callable[[str], None]
) -> tuple[tuple[OperatingPoint, ...], str]:
    """Flies to each time and linearises there; also returns why the flight ended before the last.

    A time is that of the nearest tick of the MPC.
    """
    points: list[OperatingPoint] = []
    kinematics = Kinematics(quiet.vehicle.plant)

    def p_E(state: np.ndarray) -> np.ndarray:
        return kinematics.end_effector(split_state(state)).p_E

    monitor = Monitor(quiet.scenario, quiet.diagram, quiet.context, p_E)
    for time in times:
        progress(f"{time:g} s")
        end_s = quiet.start_s(quiet.multiple(quiet.scenario.settle_s + time))
        while quiet.context.get_time() < end_s - 1e-9:
            try:
                with np.errstate(over="ignore", invalid="ignore"):
                    quiet.advance(min(quiet.context.get_time() + MONITOR_PERIOD_S, end_s))
                reason, cause = monitor.ending()
            except (Exception, SystemExit) as error:
                reason, cause = "lost", monitor.cause_of_loss(error)
            if reason:
                return tuple(points), f"the flight ended before {time:g} s: {reason}, {cause}"
        points.append(_point(quiet, LinearLoop(_linearized(quiet)), time))
    return tuple(points), ""
