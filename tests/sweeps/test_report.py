"""Summary, table and figure of a sweep."""

import json
import shlex
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import rankdata

from aerodrake.cli import main
from aerodrake.scenario.load import load_scenario
from aerodrake.sweeps.folder import read_rows, sweep_folder
from aerodrake.sweeps.outcomes import Outcomes
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.report import sweep_table, write_report
from tests.in_this_process import call_in_this_process
from tests.plans import by_key

VARY = ["wind.gust_m_s[0]=uniform(0, 2)", "residual.mode=choice(off, online)"]


def row(trial, reason="completed", lap=None, settled=None, mean=None) -> dict:
    if reason == "failed":
        return {**trial.header(), "exit_reason": reason, "exit_cause": "bad luck"}
    error = {"lap_mean_m": lap, "settled_mean_m": settled, "mean_m": mean}
    return {**trial.header(), "exit_reason": reason, "exit_cause": "", "error": error}


def write(folder: Path, rows, vary=VARY) -> tuple[Plan, dict]:
    """Writes a sweep with these rows, in reverse order."""
    plan = Plan.make(load_scenario("hover"), by_key(vary), len(rows))
    with sweep_folder(folder, plan, resumes=False) as opened:
        for index in reversed(range(len(rows))):
            opened.append(row(opened.plan.trial(index), **rows[index]), None)
        summary = write_report(opened)
    assert json.loads((folder / Plan.files.summary).read_text()) == summary
    assert (folder / Plan.files.figure).read_bytes().startswith(b"\x89PNG")
    return plan, summary


def test_errors_count_completed_flights_and_endings_all_flights(tmp_path):
    errors = np.random.default_rng(0).uniform(0, 0.01, 20)
    rows = [{"mean": error} for error in errors]
    rows += [{"reason": "lost", "mean": 1.0}, {"reason": "failed"}, {"reason": "lost", "mean": 2.0}]
    _, summary = write(tmp_path / "sweep", rows)
    assert summary["endings"] == {"completed": 20, "failed": 1, "lost": 2}
    assert summary["error"]["key"] == "mean_m"
    figures = [summary["error"][key] for key in ("mean_m", "median_m", "p90_m", "p95_m", "max_m")]
    expected = [errors.mean(), *np.quantile(errors, [0.5, 0.9, 0.95, 1.0])]
    np.testing.assert_allclose(figures, expected, rtol=1e-11)
    table = sweep_table(summary)
    assert "23 trials, 20 completed, 1 failed, 2 lost" in table
    for value in expected:
        assert f"{1e3 * value:9.2f}" in table


def test_only_keys_with_numbers_have_a_rank_correlation(tmp_path):
    errors = np.random.default_rng(1).uniform(0, 0.01, 12)
    plan, summary = write(tmp_path / "sweep", [{"mean": error} for error in errors])
    gusts = [plan.trial(i).parameters["wind.gust_m_s[0]"] for i in range(12)]
    expected = np.corrcoef(rankdata(gusts), rankdata(errors))[0, 1]
    correlations = summary["correlations"]
    assert correlations["wind.gust_m_s[0]"]["spearman"] == pytest.approx(expected, abs=1e-11)
    assert 0 < correlations["wind.gust_m_s[0]"]["p_value"] < 1
    assert correlations["residual.mode"] is None
    lines = [line.split() for line in sweep_table(summary).splitlines()]
    assert ["wind.gust_m_s[0]:", "uniform(0,", "2)", f"{expected:+.2f}"] in [x[:4] for x in lines]
    assert ["residual.mode:", "choice(off,", "online)", "-"] in lines


def test_lost_flights_have_the_worst_rank_and_failed_flights_no_rank(tmp_path):
    vary = ["wind.gust_m_s[0]=linspace(0, 3, 12)"]
    rows = [{"mean": 1e-3}] * 6 + [{"reason": "lost", "mean": 1.0}] * 3 + [{"reason": "failed"}] * 3
    _, summary = write(tmp_path / "sweep", rows, vary)
    expected = np.corrcoef(np.arange(9), [0] * 6 + [1] * 3)[0, 1]
    correlation = summary["correlations"]["wind.gust_m_s[0]"]
    assert correlation["spearman"] == pytest.approx(expected, abs=1e-11)


@pytest.mark.parametrize(
    ("rows", "key"),
    [
        ([{"lap": 1e-3, "settled": 2e-3, "mean": 3e-3}] * 3, "lap_mean_m"),
        ([{"settled": 2e-3, "mean": 3e-3}, {"lap": 1, "settled": 2, "mean": 3}], "settled_mean_m"),
        ([{"lap": 1e-3, "mean": 3e-3}, {"reason": "lost", "mean": 1}], "lap_mean_m"),
    ],
)  # fmt: skip
def test_all_completed_flights_have_the_headline_error(rows, key, tmp_path):
    _, summary = write(tmp_path / "sweep", rows)
    assert summary["error"]["key"] == key
    assert summary["correlations"]["wind.gust_m_s[0]"] is None  # Equal errors, or too few.


def test_the_worst_are_flights_not_completed_then_the_largest_errors(tmp_path):
    rows = [{"mean": 1e-3 * i} for i in range(6)] + [{"reason": "lost"}, {"reason": "failed"}]
    plan, summary = write(tmp_path / "sweep", rows)
    assert [worst["trial"] for worst in summary["worst"]] == [6, 7, 5, 4, 3]
    for worst in summary["worst"]:
        assert worst["command"] == plan.trial(worst["trial"]).command(
            tmp_path / "sweep" / "scenario.yaml"
        )
        assert worst["command"] in sweep_table(summary)


def test_a_sweep_without_completed_flights_and_varied_keys(tmp_path):
    _, summary = write(tmp_path / "sweep", [{"reason": "lost"}] * 2, vary=[])
    assert summary["error"] is None and summary["correlations"] == {}
    assert "2 trials, 2 lost" in sweep_table(summary)


def test_a_figure_shows_a_bounded_number_of_keys(tmp_path):
    vary = [f"wind.{name}[{i}]=uniform(0, 1)" for name in ("velocity_m_s", "gust_m_s")
            for i in range(3)]  # fmt: skip
    vary += [f"flight.{name}_gain[{i}]=uniform(1, 2)" for name in ("position", "velocity")
             for i in range(3)]  # fmt: skip
    _, summary = write(tmp_path / "sweep", [{"mean": 1e-3 * i} for i in range(4)], vary)
    assert len(summary["correlations"]) == 12


def test_outcomes_are_in_the_order_of_trials(tmp_path):
    plan, _ = write(tmp_path / "sweep", [{"mean": 1e-3 * i} for i in range(4)])
    assert [r["trial"] for r in read_rows(tmp_path / "sweep")] == [3, 2, 1, 0]
    outcomes = Outcomes.read(tmp_path / "sweep", plan)
    assert outcomes.trials.tolist() == [0, 1, 2, 3]
    np.testing.assert_allclose(outcomes.error_m, [0, 1e-3, 2e-3, 3e-3])


@pytest.mark.usefixtures("undrawn")
def test_the_command_of_the_worst_trial_repeats_its_error(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("aerodrake.sweeps.loop.call_in_child", call_in_this_process)
    out, short = tmp_path / "my sweep", ["--set", "settle_s=0.02", "--set", "duration=0.06"]
    options = ["--trials", "2", "--vary", VARY[0], *short, "--jobs", "1", "--out", str(out)]
    assert main(["sweep", "hover", *options]) == 0
    output = capsys.readouterr().out
    worst = json.loads((out / Plan.files.summary).read_text())["worst"][0]
    (line,) = (line for line in output.splitlines() if line.endswith(worst["command"]))
    assert line.startswith(f"  trial {worst['trial']}, {1e3 * worst['error_m']:.3f} mm: aerodrake")
    _, *words = shlex.split(worst["command"])
    assert main([*words, "--quiet", "--out", str(tmp_path / "run")]) == 0
    figures = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert figures["error"]["mean_m"] == worst["error_m"]
    assert f"{out}: scenario.yaml, sweep.json, trials.jsonl" in output
