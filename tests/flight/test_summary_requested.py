"""Errors are relative to the reference that was asked for; the followed one is beside it."""

from dataclasses import replace

import numpy as np
import pytest

from aerodrake.flight.simulate import FlightSimulation
from aerodrake.flight.summary import summarize
from aerodrake.reports.flight_table import table
from aerodrake.scenario import MovingTarget, ReferenceJump, ReferenceNan, Scenario, Supervisor
from tests.logs import CLOVER, made


def followed(log, offset_m):
    """Returns the log with a followed reference that is off by (T,) m along x."""
    p, still = log["p_Ed_m"].copy(), np.zeros_like(log["p_Ed_m"])
    p[:, 0] += offset_m
    signals = {"v_Ed_m_s": still, "followed_p_Ed_m": p, "followed_v_Ed_m_s": still}
    return replace(log, signals={**log.signals, **signals})


def test_without_a_difference_there_is_no_second_error():
    log = made(lambda t: 0.01 + 0 * t)
    for same in (log, followed(log, 0.0)):  # Earlier logs have no followed reference.
        summary = summarize(CLOVER, same)
        assert summary["followed_error"] is None and summary["refused_s"] == 0
        assert "followed" not in table(summary, "clover")


def test_a_reference_refused_midway():
    """From 5 s to 8 s the tool is at the held point, 0.2 m from the reference."""
    log = made()
    held = (log.time_s >= 5 - 1e-9) & (log.time_s < 8 - 1e-9)
    log = followed(log, 0.2 * held)
    log.signals["p_E_m"][:, 0] += 0.2 * held
    summary = summarize(CLOVER, log)
    error, other = summary["error"], summary["followed_error"]
    assert error["max_m"] == pytest.approx(0.2) and other["max_m"] == 0
    assert error["mean_m"] == pytest.approx(0.2 * 300 / 3001)
    assert error["lap_mean_m"] == pytest.approx(0.2 * 300 / 2401)
    assert error["approach_s"] == 0 and summary["refused_s"] == pytest.approx(3.0)
    text = table(summary, "clover")
    assert "reference not followed        3.00 s" in text


def test_a_task_that_was_never_begun_has_no_approach():
    """Although the tool is within d_h of the reference all the time."""
    summary = summarize(CLOVER, followed(made(), 0.05))
    assert summary["error"]["max_m"] == 0
    assert summary["error"]["approach_s"] is None
    assert summary["refused_s"] == pytest.approx(30.0)


@pytest.fixture(scope="module")
def refused():
    """A target on the ground that is not followed, and the flight's summary."""
    target = MovingTarget(height_m=0.0)
    scenario = Scenario(reference=target, duration=0.5, settle_s=0.1)
    return scenario, summarize(scenario, FlightSimulation(scenario).fly())


def test_a_refused_target_is_far_away(refused):
    scenario, summary = refused
    error = summary["error"]
    assert summary["exit_cause"].startswith("reference_out_of_reach")
    assert error["mean_m"] > 1.5 and error["approach_s"] is None
    assert summary["followed_error"]["max_m"] < 1e-6
    assert summary["refused_s"] == pytest.approx(scenario.duration)
    text = table(summary, "moving_target")
    assert "first within d_h                        5.00 s" in text  # The paper's alone.


def test_a_refused_reference_is_not_followed_even_where_the_vehicle_is():
    """The held point is the reference: the vehicle hovers there in HOLD."""
    scenario = Scenario(duration=0.2, settle_s=0.1, supervisor=Supervisor(lowest_m=1.3))
    summary = summarize(scenario, FlightSimulation(scenario).fly())
    assert summary["refused_s"] == pytest.approx(scenario.duration)
    assert summary["error"]["approach_s"] is None and summary["followed_error"] is not None


def test_a_reference_refused_at_time_0_is_not_approached_before_it_is_accepted():
    """In time with the ticks, since a verdict is of a tick."""
    fault = ReferenceNan(start_s=-0.1, duration_s=0.2)
    scenario = Scenario(duration=0.3, settle_s=0.2, faults=(fault,))
    summary = summarize(scenario, FlightSimulation(scenario).fly())
    assert summary["refused_s"] == pytest.approx(0.1, abs=scenario.rates.mpc_period_s)
    assert summary["error"]["approach_s"] == pytest.approx(0.1, abs=scenario.rates.mpc_period_s)


def test_a_fault_of_the_reference_is_an_error_of_the_task():
    """The jump is followed, away from the reference that was asked for."""
    jump = ReferenceJump(start_s=-60, duration_s=100, offset_m=(0.3, 0.0, 0.0))
    scenario = Scenario(duration=0.2, settle_s=0.1, faults=(jump,))
    log = FlightSimulation(scenario).fly()
    off = log["followed_p_Ed_m"] - log["p_Ed_m"]
    np.testing.assert_allclose(off, np.tile([0.3, 0.0, 0.0], (len(off), 1)), atol=1e-12)
    assert not log.is_followed.any() and log.error_m.max() < 0.1
