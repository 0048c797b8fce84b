"""Limits of the figures of `aerodrake bench`.

Not part of the default test run: `pytest tests/benchmarks` on an idle machine. It takes ten
minutes, or one with AERODRAKE_BENCH=quick.
"""

import json
import os

import numpy as np
import pytest

from aerodrake.bench.solvers import evaluate
from aerodrake.bench.ticks import OWN, record_ticks, replay
from aerodrake.cli import main
from aerodrake.model.qp.result import QpStatus
from aerodrake.scenario.load import load_scenario, packaged_scenarios

PERIOD_MS = 20.0

MPC_SCENARIOS = [n for n in packaged_scenarios() if load_scenario(n).controller == "mpc"]


@pytest.fixture(scope="module")
def figures(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    options = ["--quick"] if os.environ.get("AERODRAKE_BENCH") == "quick" else []
    out, file = folder / "out", folder / "figures.json"
    assert main(["bench", *options, "--out", str(out), "--json", str(file)]) == 0
    return json.loads(file.read_text())


def test_a_tick_is_as_fast_as_daqp(figures):
    assert figures["peers"]["daqp"]["median_ratio"] <= 0.8
    assert figures["peers"]["daqp"]["p99_ratio"] <= 1.5


def test_osqp_is_in_time_by_itself(figures):
    for times in (figures["solvers"]["without shortcut"], figures["tick"]["bounded"]):
        assert times["median_ms"] <= 3.0
        assert times["p99_ms"] <= 10.0


def test_a_tick_is_exact(figures):
    assert figures["tick"]["exact_residual_max"] < 1e-9
    assert figures["tick"]["u0_error_max"] <= 1e-3


def test_no_tick_exceeds_its_period(figures):
    assert figures["tick"]["worst_ms"] < PERIOD_MS


def test_the_closed_loop_takes_at_most_twice_the_time_of_its_plant(figures):
    assert figures["closed_loop_over_plant"] <= 2.0
    assert figures["real_time_factor"] >= 10.0
    assert figures["loop"]["monitor_and_log_share"] < 0.03


def test_tick_time_is_at_most_quadratic_in_the_horizon(figures):
    assert figures["scaling"]["horizon_exponent"] <= 2.0


def test_memory_is_bounded_and_flat(figures):
    assert figures["peak_rss_mb"] < 700
    assert figures["rss_growth_mb"] < 50


def test_commands_start_quickly(figures):
    assert figures["startup"]["help_s"] < 0.3
    assert figures["startup"]["hover_s"] < 5.0


@pytest.mark.parametrize("name", MPC_SCENARIOS)
def test_every_tick_of_every_scenario_is_exact_and_in_time(name):
    recorded = record_ticks(load_scenario(name))
    variants = {"osqp": {"shortcut": False}, "active_set": {"solver": "active_set"}}
    measured = evaluate(recorded, replay(recorded, {}, 2, variants))
    assert measured.residual < 1e-9
    for solver, tolerance in ((OWN, 1e-3), ("osqp", 1e-3), ("active_set", 1e-8)):
        assert measured.u0_error[solver].max() <= tolerance
        assert measured.replay.tick_ms(solver).max() < PERIOD_MS
        statuses = np.array(measured.replay.statuses[solver])
        is_exact = statuses[measured.is_constrained] == QpStatus.SOLVED
        assert is_exact.all()
