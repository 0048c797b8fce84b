"""What the machine has no room for ends a sweep, and is flown when it goes on."""

import json
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from aerodrake.cli import main
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps import loop as module
from aerodrake.sweeps.folder import ROWS, read_rows, sweep_folder
from aerodrake.sweeps.loop import processes, sweep
from aerodrake.sweeps.plan import Plan
from tests.room import room_for

SCENARIO = ("hover", "--set", "settle_s=0", "--set", "duration=0.2")
ARGV = ["sweep", *SCENARIO, "--trials", "2", "--jobs", "1", "--quiet", "--out", "swept"]


@pytest.fixture
def plan() -> Plan:
    return Plan.make(load_scenario("hover"), [], 3)


def test_a_disk_that_is_full_leaves_no_row(tmp_path, monkeypatch, capfd):
    """Large enough for the sweep's folder, too small for a flight."""
    monkeypatch.chdir(tmp_path)
    with room_for(12_000):
        code = main(ARGV)
    said, errors = capfd.readouterr()
    assert code == 1 and said == ""
    hint, said = errors.splitlines()
    assert "0 of 2 trials are in swept; to go on: aerodrake sweep hover" in hint
    assert said.startswith("aerodrake: trial 0 could not be flown: ") and "File too large" in said
    assert [*read_rows(tmp_path / "swept")] == []
    assert main([*ARGV, "--resume"]) == 0
    assert {row["exit_reason"] for row in read_rows(tmp_path / "swept")} == {"completed"}


@pytest.mark.parametrize("python", ["/bin/false", "/no/such/python"])
def test_a_child_that_cannot_start_leaves_no_row(plan, python, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", python)
    with (
        pytest.raises(ProcessDied, match="before it began|could not be flown: FileNotFound"),
        processes(2) as executor,
        sweep_folder(tmp_path / "swept", plan, False) as folder,
    ):
        sweep(folder, executor)
    assert (tmp_path / "swept" / ROWS).read_text() == ""


def test_rows_that_came_before_stay(plan, tmp_path, monkeypatch):
    def apart(_, trial):
        if trial.index == 1:
            raise MemoryError
        return {**trial.head(), "exit_reason": "completed"}, None

    monkeypatch.setattr(module, "apart", apart)
    with (
        pytest.raises(ProcessDied, match="^trial 1 could not be flown: MemoryError$"),
        ThreadPoolExecutor(1) as executor,
        sweep_folder(tmp_path / "swept", plan, False) as folder,
    ):
        sweep(folder, executor)
    rows = (tmp_path / "swept" / ROWS).read_text().splitlines()
    assert [json.loads(row)["trial"] for row in rows] == [0]
