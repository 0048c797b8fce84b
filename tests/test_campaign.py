"""Flights with random faults end with an exit reason, finite numbers and an empty stderr.

A few are flown in this process by default, 500 in child processes with `--long`; `python -m
tests.campaign` flies others.
"""

import pytest

from aerodrake.cli import main
from tests.campaign import DURATION_S, campaign, check_flight, draw, must_complete

SAMPLE, ALL = 2, 500


def test_no_flight_has_problems(long, tmp_path, capfd, undrawn):
    def run(arguments):
        code = main(arguments)
        return code, capfd.readouterr().err

    if long:
        results = campaign(range(ALL), 2, tmp_path)
    else:
        results = [check_flight(seed, tmp_path, run) for seed in range(SAMPLE)]
    assert not [result for result in results if result.problems]


def test_a_seed_determines_the_scenario():
    assert draw(7) == draw(7) != draw(8)


def test_all_kinds_are_drawn_alone_and_together():
    drawn = [draw(seed) for seed in range(300)]
    alone = {s["faults"][0]["kind"] for s in drawn if len(s["faults"]) == 1}
    assert len(alone) == 17 and any(len(s["faults"]) > 2 for s in drawn)
    completed = sum(map(must_complete, drawn))
    assert 75 < completed < 200


@pytest.mark.parametrize("duration_s", [0.05, 30.0])
def test_only_a_short_fault_must_complete(duration_s):
    scenario = {"faults": [{"kind": "mpc_missed", "start_s": 1.0, "duration_s": duration_s}]}
    assert must_complete(scenario) == (duration_s < DURATION_S)
