"""Faults of a flight and conditions that its supervisor detected, over time."""

from typing import Any, NamedTuple

import numpy as np

from aerodrake.flight.log import FlightLog
from aerodrake.model.supervision.conditions import Condition, Signal, conditions
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import Scenario

DELTA_UNUSED = "delta_unused"
"""Cause of the event, at the end of a flight, that its residual Delta was never used."""

BY_JOINT = {
    Signal.JOINT_OSCILLATION: "joint_oscillation_rad_s",
    Signal.TORQUE_AT_LIMIT: "torque_at_limit",
}
"""Signals of the supervisor that are the largest of all joints, and the keys of these in a log."""


def events(scenario: Scenario, log: FlightLog) -> list[dict[str, Any]]:
    """Returns each trigger and clearing of a condition, in order of time.

    Keys:
        time_s: Reference time.
        cause: Name of the condition, or `DELTA_UNUSED`.
        mode: Label of the `SafeMode` that it requests.
        event: `triggered` or `cleared`.
        joint: Name of the joint for which a condition on joints triggered; null otherwise.
    """
    defined = conditions(scenario.supervisor)
    active = log["conditions"] > 0.5
    changes = np.diff(active, axis=0, prepend=np.zeros((1, active.shape[1]), dtype=bool))
    changed = []
    for row, i in zip(*np.nonzero(changes), strict=True):
        condition, is_active = defined[i], active[row, i]
        joint = _joint(log, row, condition) if is_active else None
        event = _event(log.time_s[row], condition.name, condition.mode, is_active, joint)
        changed.append(event)
    if scenario.residual.mode != "off" and is_delta_unused(log):
        changed.append(_event(log.time_s[-1], DELTA_UNUSED, SafeMode.NOMINAL, True))
    return changed


def is_delta_unused(log: FlightLog) -> bool:
    """Returns True if every prediction of the base velocity was made with a zero Delta."""
    errors = log["prediction_error_m_s"], log["nominal_prediction_error_m_s"]
    return np.array_equal(*errors, equal_nan=True)


def _event(
    time_s: float, cause: str, mode: SafeMode, is_triggered: bool, joint: str | None = None
) -> dict[str, Any]:
    event = "triggered" if is_triggered else "cleared"
    return {
        "time_s": float(time_s),
        "cause": cause,
        "mode": mode.label,
        "event": event,
        "joint": joint,
    }


def _joint(log: FlightLog, row: int, condition: Condition) -> str | None:
    """Returns the joint with the largest value while a condition in `BY_JOINT` has triggered."""
    if condition.signal not in BY_JOINT:
        return None
    begin = np.searchsorted(log.time_s, log.time_s[row] - condition.trigger_s - 1e-9)
    values = log[BY_JOINT[condition.signal]][begin : row + 1]
    return log.vehicle.joint_names[values.sum(axis=0).argmax()]


def safe_modes(log: FlightLog, period: float) -> dict[str, float]:
    """Returns the time in s in each safe mode, by its label, from samples `period` s apart."""
    samples = np.bincount(log["supervisor_mode"][:-1].astype(int), minlength=len(SafeMode))
    return {mode.label: float(round(samples[mode] * period, 9)) for mode in SafeMode}


class Span(NamedTuple):
    """Time span of an injected fault, or of an active condition.

    Attributes:
        name: Kind of the fault, or name of the condition.
        mode: Safe mode that the condition requests; None for a fault.
        start_s, end_s: Reference time, within the flight.
    """

    name: str
    mode: SafeMode | None
    start_s: float
    end_s: float


def spans(scenario: Scenario, log: FlightLog) -> list[Span]:
    """Returns the scenario's faults within the flight, then the supervisor's conditions."""
    begin, end = log.time_s[0], log.time_s[-1]
    result = [
        Span(fault.kind, None, max(fault.start_s, begin), min(fault.end_s, end))
        for fault in scenario.faults
        if fault.start_s < end and fault.end_s > begin
    ]
    defined = conditions(scenario.supervisor)
    active = np.pad(log["conditions"] > 0.5, ((1, 1), (0, 0))).astype(int)
    times = np.append(log.time_s, end)
    # The log of an earlier version lacks the last conditions.
    for condition, column in zip(defined, active.T, strict=False):
        change = np.diff(column)
        for first, last in zip(np.flatnonzero(change > 0), np.flatnonzero(change < 0), strict=True):
            result.append(Span(condition.name, condition.mode, times[first], times[last]))
    return result
