"""`aerodrake.budget`, its result and its command."""

import json
from concurrent.futures import ThreadPoolExecutor

import pytest

import aerodrake
from aerodrake.budgets.plan import BudgetPlan
from aerodrake.cli import main
from aerodrake.sweeps import loop
from tests.in_this_process import call_in_this_process

SHORT = {"duration": 0.04, "settle_s": 0.0, "payload.mass_kg": 0.2}


@pytest.fixture(autouse=True)
def _here(monkeypatch):
    """Flies trials in this process instead of child processes."""
    monkeypatch.setattr(loop, "call_in_child", call_in_this_process)


def test_a_budget_can_get_more_seeds(tmp_path):
    out = tmp_path / "budget"
    noisy = {**SHORT, "sensors.position_noise_m": 0.001}
    with ThreadPoolExecutor(1) as executor:
        options = {"out": out, "executor": executor, "quiet": True}
        first = aerodrake.budget("hover", noisy, seeds=1, **options)
        more = aerodrake.budget("hover", noisy, seeds=2, resume=True, **options)
    assert {path.name for path in out.iterdir()} == {*BudgetPlan.files.all}
    assert first.summary["trials"] == 6 and more.summary["trials"] == 9
    earlier, later = first.summary["all"]["by_seed_m"], more.summary["all"]["by_seed_m"]
    assert later[0] == earlier[0] != later[1]
    assert "position noise" in str(more) and "<img" in more._repr_html_()


def test_the_command_writes_what_it_prints(tmp_path, capsys):
    out = tmp_path / "budget"
    sets = [word for key, value in SHORT.items() for word in ("--set", f"{key}={value}")]
    assert main(["budget", "hover", *sets, "--seeds", "1", "--jobs", "1", "--out", str(out)]) == 0
    summary = json.loads((out / BudgetPlan.files.summary).read_text())
    printed = capsys.readouterr().out
    assert f"{1e3 * summary['costs'][0]['alone']['mean_m']:.3f}" in printed


def test_bad_input_is_one_line(tmp_path, capsys):
    assert main(["budget", "hover", "--out", str(tmp_path / "b")]) == 2
    assert "expected a scenario with flaws" in capsys.readouterr().err
    assert main(["budget", "clover_realistic", "--resume"]) == 2
    assert "--resume: expected --out DIR with the folder of a budget" in capsys.readouterr().err
    with pytest.raises(SystemExit, match="2"):
        main(["budget", "clover_realistic", "--seeds", "0"])
