"""The summary of a flight, as in `summary.json`."""

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from aerodrake.flight.events import events, safe_modes
from aerodrake.flight.log import FlightLog
from aerodrake.model.mpc.tick import MISSED
from aerodrake.model.mpc.weight_allocation import Mode
from aerodrake.model.qp.result import QpStatus
from aerodrake.model.reference.curves import make_reference
from aerodrake.model.reference.reference_curve import hover_then_follow
from aerodrake.model.residual.delta_blend import DeltaSource
from aerodrake.model.vehicle.kinematics import Kinematics
from aerodrake.scenario import Scenario
from aerodrake.support.version import __version__

SETTLED_AFTER_S = 15.0
"""Reference time in s from which errors count as settled, as in the paper's pursuit."""

SAME_REFERENCE_M = 1e-6
"""Median distance up to which a flown reference is the scenario's."""

HEADLINES = {"lap_mean_m": "one lap", "settled_mean_m": "after 15 s", "mean_m": "mean"}
"""Keys of `error` to compare flights by, in the order of preference, and their labels."""

Summaries = Mapping[str, Mapping[str, Any]]
"""Summaries by the name of the flight; those of failed flights have no `error`."""


@np.errstate(over="ignore", invalid="ignore")  # What overflows is null.
def summarize(scenario: Scenario, log: FlightLog) -> dict[str, Any]:
    """Returns the results of a flight, null if undefined. Errors are of the true state.

    Keys:
        instability: Sentence on the hover of a flight that ended early; null, which `aerodrake.fly`
            replaces if the loop is unstable.
        error: m, distance of the end-effector from the reference that was asked for, from
            reference time 0 on: mean, rms, max; mean of one whole lap after the smooth
            start; settled mean (after 15 s); and the time in s at which it is
            first within d_h of a reference that is followed.
        followed_error: m, distance from the reference that was followed: mean, rms, max and
            settled mean; null if that is the one that was asked for throughout.
        refused_s: s, from reference time 0 on, for which another reference was followed.
        orientation: rad, angle between the tool's axis and its desired direction
            from reference time 0 on: mean, rms, max and settled mean; null without
            orientation task.
        base_error: the same as `error` for the base and its setpoint.
        mpc: see `_mpc`.
        modes: s in each mode of the weight allocation.
        safe_modes: s in each mode of the supervisor, including the initial hover.
        events: Changes of the supervisor's conditions, see `aerodrake.flight.events`.
        arm: m, largest distance of the end-effector from the centre of the
            learning space within the joint limits, d_edge of the scenario, and
            largest d_o of the flight; s with d_o beyond d_h; rad, smallest
            distance of a joint to its limits (negative: beyond one); and by joint the
            share of time with its torque at the limit, from reference time 0 on.
        residual: RMS error in m/s of predicting the base velocity over one
            period, with and without the network. Unless the mode is off: s with the
            Delta of each layer, and without Delta. If the last layer learned: its learning
            rate, and the least bound of the flight below which the step is stable.
    """
    lap = _flown_lap(scenario, log)
    simulated_s = log.time_s[-1] + scenario.settle_s
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "version": __version__,
        "simulated_s": rounded(simulated_s),
        "wall_s": rounded(log.wall_s),
        "real_time_factor": rounded(simulated_s / log.wall_s),
        "exit_reason": log.exit_reason,
        "exit_cause": log.exit_cause,
        "instability": None,
        **_reference_errors(scenario, log, lap),
        "base_error": _errors(log.base_error_m, log.time_s, lap, scenario.allocation.d_h_m),
        "orientation": _spread(log.tool_angle_rad, log.time_s, "rad"),
        "mpc": _mpc(scenario, log, simulated_s),
        "modes": _durations(log, "mode", Mode, scenario.rates.flight_period_s),
        "safe_modes": safe_modes(log, scenario.rates.flight_period_s),
        "events": events(scenario, log),
        "arm": _arm(scenario, log),
        "residual": _residual(scenario, log),
    }


def headline(summaries: Summaries) -> str:
    """Returns the key of `error` to compare flights by: the first that any of them has."""
    flown = [s["error"] for s in summaries.values() if "error" in s]
    return next((k for k in HEADLINES if any(e[k] is not None for e in flown)), "mean_m")


def failure(error: Exception) -> dict[str, str]:
    """Returns the summary of a flight whose process raised an exception or died."""
    lines = str(error).splitlines() or [""]
    cause = f"{type(error).__name__}: {lines[0]}".removesuffix(": ")
    return {"exit_reason": "failed", "exit_cause": cause}


WALL_TIMES = ("wall_s", "real_time_factor")
MPC_WALL_TIMES = ("median_ms", "p99_ms", "overruns")


def repeatable(summary: dict[str, Any]) -> dict[str, Any]:
    """Returns the results without wall times, which are the same each time it is flown."""
    figures = {key: value for key, value in summary.items() if key not in WALL_TIMES}
    mpc = {key: value for key, value in summary["mpc"].items() if key not in MPC_WALL_TIMES}
    return {**figures, "mpc": mpc}


def to_json(summary: dict[str, Any]) -> str:
    """Returns results as strict JSON (no NaN), with their keys in order."""
    return json.dumps(summary, indent=2, allow_nan=False) + "\n"


def _mpc(scenario: Scenario, log: FlightLog, simulated_s: float) -> dict[str, Any]:
    """Returns results of the controller's ticks.

    Keys:
        solver: `mpc.solver` of the scenario; null for CLIK.
        ticks: Number of computed ticks.
        solved_by: These ticks by how they were solved: by the unconstrained minimiser, by the
            solver, for CLIK with accelerations at a limit, by the solver with softened custom
            constraints or with relaxed bounds, or not at all.
        median_ms, p99_ms: Wall time of a tick, forming and solving.
        solver_fallbacks: Ticks that were not solved and followed the last plan.
        missed: Ticks that were not computed.
        overruns: Ticks whose wall time was longer than the period.
    """
    period_s, ticks_ms = scenario.rates.mpc_period_s, log["tick_ms"]
    due = math.ceil(round(simulated_s / period_s, 6))
    # The status port has the last tick, and the log several samples for each tick.
    stride = round(period_s / scenario.rates.flight_period_s)
    samples = np.minimum(stride * np.arange(1, due + 1), len(log.time_s) - 1)
    counts = np.bincount(log["qp_status"][samples].astype(int), minlength=MISSED)
    solver = scenario.mpc.solver if scenario.controller == "mpc" else None
    unsolved = counts[QpStatus.RELAXED + 1 : MISSED].sum()
    solved_by = {
        "unconstrained": counts[QpStatus.UNCONSTRAINED],
        solver or scenario.controller: counts[QpStatus.SOLVED] + counts[QpStatus.INACCURATE],
        "softened": counts[QpStatus.SOFTENED],
        "relaxed": counts[QpStatus.RELAXED],
        "none": unsolved,
    }
    return {
        "solver": solver,
        "ticks": len(ticks_ms),
        "solved_by": {name: int(count) for name, count in solved_by.items()},
        "median_ms": rounded(np.median(ticks_ms)) if len(ticks_ms) else None,
        "p99_ms": rounded(np.percentile(ticks_ms, 99)) if len(ticks_ms) else None,
        "solver_fallbacks": int(unsolved),
        "missed": max(0, due - len(ticks_ms)),
        "overruns": int((ticks_ms > 1e3 * period_s).sum()),
    }


def _arm(scenario: Scenario, log: FlightLog) -> dict[str, Any]:
    vehicle, flown = log.vehicle, log.time_s >= 0
    d_o = log.d_o_m[flown]
    q = log["q_rad"][flown]
    reach = Kinematics(vehicle.plant).farthest_reach(vehicle.p_O, vehicle.lower, vehicle.upper)
    clearance = np.minimum(q - vehicle.lower, vehicle.upper - q)
    at_limit = log["torque_at_limit"][log.is_flown].mean(axis=0)
    outside = np.count_nonzero(d_o[:-1] > scenario.allocation.d_h_m)
    return {
        "farthest_reach_m": rounded(reach),
        "d_edge_m": scenario.allocation.d_edge_m,
        "farthest_d_o_m": rounded(d_o.max()) if len(d_o) else None,
        "outside_s": rounded(outside * scenario.rates.flight_period_s),
        "least_room_rad": rounded(clearance.min()) if len(d_o) else None,
        "torque_at_limit": dict(zip(vehicle.joint_names, map(rounded, at_limit), strict=True)),
    }


def _residual(scenario: Scenario, log: FlightLog) -> dict[str, Any]:
    flown, config, period_s = log.time_s >= 0, scenario.residual, scenario.rates.flight_period_s
    source_s = bound = None
    if config.mode != "off":
        source_s = _durations(log, "delta_source", DeltaSource, period_s)
    if config.mode == "online":
        bounds = log["stable_learning_rate"]  # 0 without samples.
        bound = rounded(bounds.min(initial=np.inf, where=bounds > 0))
    return {
        "mode": config.mode,
        "prediction_rmse_m_s": {
            "with_network": _rms(log["prediction_error_m_s"][flown]),
            "without_network": _rms(log["nominal_prediction_error_m_s"][flown]),
        },
        "source_s": source_s,
        "learning_rate": None if bound is None else config.learning_rate,
        "stable_learning_rate": bound,
    }


def _durations(
    log: FlightLog, key: str, kind: type[Mode | DeltaSource], period_s: float
) -> dict[str, float | None]:
    """Returns the time in s with each value of an enumeration, from reference time 0 on."""
    # Each sample counts for the time until the next, so the last one does not count.
    values = log[key][:-1][log.time_s[:-1] >= 0].astype(int)
    counts = np.bincount(values, minlength=len(kind))
    return {value.label: rounded(counts[value] * period_s) for value in kind}


def _spread(values: np.ndarray | None, time_s: np.ndarray, unit: str) -> dict[str, float | None]:
    """Returns statistics from reference time 0 on; null without values."""
    if values is None:
        values = time_s = np.empty(0)
    flown = values[time_s >= 0]
    return {
        f"mean_{unit}": _mean(flown),
        f"rms_{unit}": _rms(flown),
        f"max_{unit}": rounded(flown.max()) if len(flown) else None,
        f"settled_mean_{unit}": _mean(values[time_s >= SETTLED_AFTER_S]),
    }


def _flown_lap(scenario: Scenario, log: FlightLog) -> tuple[float, float] | None:
    """Returns the lap of the scenario's reference, unless mostly another one was flown."""
    curve = make_reference(scenario.reference, log.vehicle.p_E)
    flown = log.time_s >= 0
    if curve.lap is None or not flown.any():
        return None
    p_Ed, _ = hover_then_follow(curve, log.vehicle.p_E, log.time_s[flown])
    deviation = np.linalg.norm(log["p_Ed_m"][flown] - p_Ed, axis=1)
    return curve.lap if np.median(deviation) < SAME_REFERENCE_M else None


def _reference_errors(
    scenario: Scenario, log: FlightLog, lap: tuple[float, float] | None
) -> dict[str, Any]:
    """Returns `error`, `followed_error` and `refused_s`."""
    d_h, time_s, is_followed = scenario.allocation.d_h_m, log.time_s, log.is_followed
    error = _errors(log.error_m, time_s, lap, d_h)
    refused = np.count_nonzero(~is_followed[:-1] & (time_s[:-1] >= 0))
    followed = None
    if not is_followed[time_s >= 0].all():
        near = np.flatnonzero(is_followed & (time_s >= 0) & (log.error_m <= d_h))
        error["approach_s"] = rounded(time_s[near[0]]) if len(near) else None
        followed = _spread(log.followed_error_m, time_s, "m")
    refused_s = rounded(refused * scenario.rates.flight_period_s)
    return {"error": error, "followed_error": followed, "refused_s": refused_s}


def _errors(
    error: np.ndarray, time_s: np.ndarray, lap: tuple[float, float] | None, d_h: float
) -> dict[str, float | None]:
    end = time_s[-1] + 1e-9
    flown = time_s >= 0
    near = np.flatnonzero(flown & (error <= d_h))
    on_lap = np.zeros_like(flown)
    if lap is not None and end >= lap[1]:
        on_lap = (time_s >= lap[0]) & (time_s <= lap[1])
    return {
        **_spread(error, time_s, "m"),
        "lap_mean_m": _mean(error[on_lap]),
        "approach_s": rounded(time_s[near[0]]) if len(near) else None,
    }


def _mean(values: np.ndarray) -> float | None:
    return rounded(values.mean()) if len(values) else None


def _rms(values: np.ndarray) -> float | None:
    """Returns the root mean square length of the rows; null without rows."""
    return rounded(math.sqrt((values**2).sum() / len(values))) if len(values) else None


def rounded(value: float) -> float | None:
    """Returns a number for a JSON file: with twelve digits, null for NaN and infinity."""
    return float(f"{value:.12g}") if math.isfinite(value) else None


def millimetres(length_m: float) -> str:
    """Formats a length in mm for a table, with two digits, below 1 mm with three."""
    length = f"{1e3 * length_m:.2f}"
    return length if float(length) >= 1 else f"{1e3 * length_m:.3f}"
