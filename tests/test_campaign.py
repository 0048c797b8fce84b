"""Flights in which anything fails end by name, with numbers, and without a word on stderr.

A few in this process by default, 500 with `--long`, in processes of their own; `python -m
tests.campaign` flies any others.
"""

import pytest

from aerodrake.cli import main
from tests.campaign import DURATION_S, campaign, draw, is_ridden_out, judge

SAMPLE, ALL = 2, 500


def test_nothing_is_wrong_with_any_flight(long, tmp_path, capfd, undrawn):
    def run(arguments):
        code = main(arguments)
        return code, capfd.readouterr().err

    if long:
        verdicts = campaign(range(ALL), 2, tmp_path)
    else:
        verdicts = [judge(seed, tmp_path, run) for seed in range(SAMPLE)]
    assert not [verdict for verdict in verdicts if verdict.wrong]


def test_a_seed_is_a_scenario():
    assert draw(7) == draw(7) != draw(8)


def test_all_kinds_are_drawn_alone_and_together():
    drawn = [draw(seed) for seed in range(300)]
    alone = {s["faults"][0]["kind"] for s in drawn if len(s["faults"]) == 1}
    assert len(alone) == 17 and any(len(s["faults"]) > 2 for s in drawn)
    ridden_out = sum(map(is_ridden_out, drawn))
    assert 75 < ridden_out < 200


@pytest.mark.parametrize("lasts", [0.05, 30.0])
def test_what_lasts_is_not_ridden_out(lasts):
    scenario = {"faults": [{"kind": "mpc_missed", "start_s": 1.0, "duration_s": lasts}]}
    assert is_ridden_out(scenario) == (lasts < DURATION_S)
