"""Events and spans, from conditions as they are logged."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.events import Span, events, safe_modes, spans
from aerodrake.flight.log import FlightLog
from aerodrake.model.supervision.conditions import conditions
from aerodrake.model.supervision.safe_mode import SafeMode
from aerodrake.scenario import MpcMissed, Push, Residual, Scenario

NAMES = [condition.name for condition in conditions(Scenario().supervisor)]
TIME_S = np.round(np.arange(-1.0, 3.0, 0.01), 9)
SCENARIO = Scenario(
    faults=(Push(start_s=1.0, duration_s=10.0), MpcMissed(start_s=3.5), Push(start_s=-9.0))
)


@pytest.fixture
def log(vehicle) -> FlightLog:
    active = np.zeros((len(TIME_S), len(NAMES)))
    active[110:160, NAMES.index("saturated")] = 1
    active[120:150, NAMES.index("plan_outage")] = 1
    active[390:, NAMES.index("plan_outage")] = 1
    mode = np.zeros(len(TIME_S))
    mode[120:150] = mode[390:] = SafeMode.HOLD
    signals = {"time_s": TIME_S, "conditions": active, "supervisor_mode": mode}
    return FlightLog(signals, "hold", "plan_outage", 1.0, vehicle)


def test_events_are_in_order_and_named(log):
    changes = events(SCENARIO, log)
    assert [(e["time_s"], e["cause"], e["event"], e["mode"]) for e in changes] == [
        (0.1, "saturated", "triggered", "nominal"),
        (0.2, "plan_outage", "triggered", "hold"),
        (0.5, "plan_outage", "cleared", "hold"),
        (0.6, "saturated", "cleared", "nominal"),
        (2.9, "plan_outage", "triggered", "hold"),
    ]


def test_events_name_the_joint(log):
    """It is at its limit for the largest share of the time after which the condition triggers."""
    rows = np.zeros((len(TIME_S), len(log.vehicle.joint_names)))
    rows[50:100, 1] = rows[90:120, 2] = 1
    oscillation = np.zeros_like(rows)
    oscillation[120:, 4] = 0.6
    log.signals.update(torque_at_limit=rows, joint_oscillation_rad_s=oscillation)
    log["conditions"][121:, NAMES.index("torque_at_limit")] = 1
    log["conditions"][130:160, NAMES.index("joint_oscillation")] = 1
    named = [(e["cause"], e["event"], e["joint"]) for e in events(SCENARIO, log) if e["joint"]]
    assert named == [
        ("torque_at_limit", "triggered", "elbow_pitch"),
        ("joint_oscillation", "triggered", "wrist_pitch"),
    ]


def test_a_condition_active_at_the_first_sample_is_an_event(log):
    log["conditions"][0, 0] = 1
    assert events(SCENARIO, log)[0]["time_s"] == -1.0


@pytest.mark.parametrize("mode", ["off", "offline", "online"])
@pytest.mark.parametrize("used_m_s", [0.0, 1e-9])
def test_a_delta_that_is_never_used_is_an_event(log, mode, used_m_s):
    """In the prediction of every tick; with NaN where a measurement is."""
    errors = np.random.default_rng(0).normal(size=(len(TIME_S), 3))
    errors[7] = np.nan
    used = errors.copy()
    used[50, 1] += used_m_s
    log.signals.update(nominal_prediction_error_m_s=errors, prediction_error_m_s=used)
    scenario = replace(SCENARIO, residual=Residual(mode=mode))
    last = events(scenario, log)[-1]
    unused = {"time_s": 2.99, "cause": "delta_unused", "mode": "nominal", "event": "triggered"}
    unused["joint"] = None
    assert (last == unused) == (mode != "off" and used_m_s == 0)


def test_spans_are_within_the_flight(log):
    assert spans(SCENARIO, log) == [
        Span("push", None, 1.0, pytest.approx(2.99)),
        Span("plan_outage", SafeMode.HOLD, 0.2, 0.5),
        Span("plan_outage", SafeMode.HOLD, 2.9, pytest.approx(2.99)),
        Span("saturated", SafeMode.NOMINAL, 0.1, 0.6),
    ]


def test_time_in_safe_modes_adds_up(log):
    seconds = safe_modes(log, 0.01)
    assert seconds["hold"] == pytest.approx(0.39)
    assert seconds["descend"] == seconds["stop"] == 0
    assert sum(seconds.values()) == pytest.approx(3.99)
