"""Summary, table and figure of an error budget."""

import json

import numpy as np
import pytest

from aerodrake.budgets.plan import BudgetPlan
from aerodrake.budgets.report import budget_table, write_budget
from aerodrake.scenario.load import load_scenario, override
from aerodrake.sweeps.folder import sweep_folder

KEYS = {"payload.mass_kg": 0.1, "sensors.position_noise_m": 0.001}
ERRORS_M = {
    "clean": [0.0001],
    "all": [0.002, 0.004],
    "alone position noise": [0.001, 0.002],
    "alone payload": [0.0005],
    "without position noise": [0.0006],
    "without payload": [0.0015, None],
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder and summary of a budget with these errors; None for a lost flight."""
    path = tmp_path_factory.mktemp("budget") / "out"
    plan = BudgetPlan.make(override(load_scenario("hover"), KEYS), 2)
    with sweep_folder(path, plan, resumes=False) as opened:
        for index, (case, seed) in enumerate(plan.flights):
            kind, flaw = plan.cases[case].kind, plan.cases[case].flaw
            error = ERRORS_M[kind if flaw is None else f"{kind} {flaw.name}"][seed]
            row = {
                **plan.trial(index).header(),
                "exit_reason": "lost" if error is None else "completed",
                "exit_cause": "",
                "error": {"lap_mean_m": None, "settled_mean_m": None, "mean_m": error or 1.0},
            }
            opened.append(row, None)
        return path, write_budget(opened)


def cost(summary, name):
    return next(cost for cost in summary["costs"] if cost["flaw"] == name)


def test_costs_are_differences_seed_by_seed(folder):
    path, summary = folder
    assert json.loads((path / BudgetPlan.files.summary).read_text()) == summary
    assert summary["clean"]["mean_m"] == 0.0001 and summary["all"]["mean_m"] == 0.003
    noise, payload = cost(summary, "position noise"), cost(summary, "payload")
    np.testing.assert_allclose(noise["added"]["by_seed_m"], [0.0009, 0.0019], rtol=1e-9)
    np.testing.assert_allclose(noise["saved"]["by_seed_m"], [0.0014, 0.0034], rtol=1e-9)
    assert payload["added"]["mean_m"] == pytest.approx(0.0004)
    assert payload["saved"]["by_seed_m"] == [0.0005, None]
    assert [cost["flaw"] for cost in summary["costs"]] == ["position noise", "payload"]


def test_flights_that_did_not_complete_are_counted(folder):
    _, summary = folder
    assert cost(summary, "payload")["without"]["not_completed"] == 1
    table = budget_table(summary)
    assert "1.500 (1 lost)" in table and "mean of 2 seeds" in table


def test_the_figure_is_drawn(folder):
    path, _ = folder
    assert (path / BudgetPlan.files.figure).read_bytes().startswith(b"\x89PNG")
