"""Errors of the machine end a sweep without a row; the trial is flown when it is resumed."""

import json
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from aerodrake.cli import main
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps import loop as module
from aerodrake.sweeps.folder import read_rows, sweep_folder
from aerodrake.sweeps.loop import fly_trials, processes
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS
from tests.room import room_for

SCENARIO = ("hover", "--set", "settle_s=0", "--set", "duration=0.2")
ARGV = ["sweep", *SCENARIO, "--trials", "2", "--jobs", "1", "--quiet", "--out", "swept"]


@pytest.fixture
def plan() -> Plan:
    return Plan.make(load_scenario("hover"), {}, 3)


def test_a_full_disk_writes_no_row(tmp_path, monkeypatch, capfd):
    """The disk has room for the sweep's folder, but not for a flight."""
    monkeypatch.chdir(tmp_path)
    with room_for(12_000):
        code = main(ARGV)
    output, errors = capfd.readouterr()
    assert code == 1 and output == ""
    hint, error = errors.splitlines()
    assert "0 of 2 trials are in swept; continue with: aerodrake sweep hover" in hint
    assert error.startswith("aerodrake: trial 0 could not be flown: ") and "File too large" in error
    assert [*read_rows(tmp_path / "swept")] == []
    assert main([*ARGV, "--resume"]) == 0
    assert {row["exit_reason"] for row in read_rows(tmp_path / "swept")} == {"completed"}


def rows_of_failed_sweep(plan, path, executors, match: str) -> str:
    """Returns the rows of a sweep that ends with ProcessDied, whose message matches."""
    with (
        pytest.raises(ProcessDied, match=match),
        executors as executor,
        sweep_folder(path, plan, False) as folder,
    ):
        fly_trials(folder, executor)
    return (path / ROWS).read_text()


@pytest.mark.parametrize("python", ["/bin/false", "/no/such/python"])
def test_a_child_that_cannot_start_writes_no_row(plan, python, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "executable", python)
    match = "before the call|could not be flown: FileNotFound"
    assert rows_of_failed_sweep(plan, tmp_path / "swept", processes(2), match) == ""


def test_earlier_rows_remain(plan, tmp_path, monkeypatch):
    def call_in_child(_, trial):
        if trial.index == 1:
            raise MemoryError
        return {**trial.header(), "exit_reason": "completed"}, None

    monkeypatch.setattr(module, "call_in_child", call_in_child)
    match = "^trial 1 could not be flown: MemoryError$"
    rows = rows_of_failed_sweep(plan, tmp_path / "swept", ThreadPoolExecutor(1), match)
    assert [json.loads(row)["trial"] for row in rows.splitlines()] == [0]
