"""Flights that are explained by an unstable hover."""

from dataclasses import replace

import pytest

from aerodrake.analysis import instability
from aerodrake.analysis.instability import hover_instability
from aerodrake.scenario import Push, Scenario
from tests.analyses import point
from tests.logs import made

LOST = replace(made(until_s=2.0), exit_reason="lost", exit_cause="tilt")


@pytest.fixture
def analysed(monkeypatch):
    """Growth of the hover in 1/s, which may be an error; and the scenarios that are analysed."""
    growth, scenarios = [5.0], []

    def analyze_hover(scenario):
        scenarios.append(scenario)
        if isinstance(growth[0], BaseException):
            raise growth[0]
        return point(growth[0])

    monkeypatch.setattr(instability, "analyze_hover", analyze_hover)
    return growth, scenarios


def test_a_lost_flight_with_an_unstable_hover_has_its_sentence(analysed):
    assert hover_instability(Scenario(), LOST) == point(5.0).sentence
    held = replace(LOST, exit_reason="hold", exit_cause="joints_outage")
    assert hover_instability(Scenario(), held).startswith("unstable in hover: roll")


def test_a_stable_hover_explains_nothing(analysed):
    growth, _ = analysed
    growth[0] = -5.0
    assert hover_instability(Scenario(), LOST) is None


def test_a_command_at_its_limit_is_a_cause_of_its_own(monkeypatch):
    hover = replace(point(5.0), saturated=("elbow",))
    monkeypatch.setattr(instability, "analyze_hover", lambda _: hover)
    assert hover_instability(Scenario(), LOST) is None


@pytest.mark.parametrize("reason", ["completed", "interrupted"])
def test_other_flights_are_not_analysed(reason, analysed):
    assert hover_instability(Scenario(), replace(LOST, exit_reason=reason)) is None
    assert analysed[1] == []


def test_a_fault_explains_a_flight_once_it_has_begun(analysed):
    assert hover_instability(Scenario(faults=(Push(start_s=1.0),)), LOST) is None
    assert analysed[1] == []
    later = Scenario(faults=(Push(start_s=2.0),))
    assert hover_instability(later, LOST) == point(5.0).sentence
    assert analysed[1] == [replace(later, faults=())]


@pytest.mark.parametrize("error", [RuntimeError("no trim"), SystemExit(), MemoryError()])
def test_an_analysis_that_fails_explains_nothing(error, analysed):
    growth, _ = analysed
    growth[0] = error
    assert hover_instability(Scenario(), LOST) is None
