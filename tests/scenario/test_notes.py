"""Notes on values of a scenario that are valid but may degrade the flight."""

import dataclasses

import pytest

from aerodrake.scenario.load import load_scenario
from aerodrake.scenario.notes import value_notes


def test_warns_if_d_h_exceeds_the_learning_space_unlike_the_papers(scenario):
    assert value_notes(scenario) == []
    wide = dataclasses.replace(scenario.allocation, d_h_m=0.08)
    (note,) = value_notes(dataclasses.replace(scenario, allocation=wide))
    assert "allocation.d_h_m" in note and "0.08 m" in note and "0.05 m" in note


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"model.kind": "paper"}, "model.kind paper is for flight.interface position"),
        ({"model.kind": "exact"}, "model.kind exact is for flight.interface position"),
        ({"mpc.tilt": "held"}, "mpc.tilt held"),
        (
            {"residual.as_printed": True, "residual.max_drift": 0, "residual.gate_s": 3},
            "residual.as_printed: residual.gate_s is not used",
        ),
        (
            {"faults": [{"kind": "learner_nan"}]},
            "faults[0] learner_nan has no effect: residual.mode",
        ),
        (
            {"faults": [{"kind": "mpc_starved"}], "mpc.solver": "scs"},
            "faults[0] mpc_starved: mpc.solver scs has its own limit",
        ),
    ],
)
def test_warns_of_values_that_degrade_the_flight(changes, expected):
    *_, note = value_notes(load_scenario("hover", changes))
    assert note.startswith(expected)


def test_defaults_and_the_papers_choices_cause_no_note(scenario):
    papers = load_scenario("hover", {"flight.interface": "position", "model.kind": "paper"})
    for fine in (scenario, papers):
        assert value_notes(fine) == []
