"""What the machine has no room for ends a sweep, and is flown when it goes on."""

import json
import resource
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from aerodrake.errors import ProcessDied
from aerodrake.scenario_file import load_scenario
from aerodrake.sweep import loop as module
from aerodrake.sweep.folder import ROWS, read_rows, sweep_folder
from aerodrake.sweep.loop import processes, sweep
from aerodrake.sweep.plan import Plan

SCENARIO = ("hover", "--set", "settle_s=0", "--set", "duration=0.2")
ARGV = ["sweep", *SCENARIO, "--trials", "2", "--jobs", "1", "--quiet", "--out", "swept"]


@pytest.fixture
def plan() -> Plan:
    return Plan.make(load_scenario("hover"), [], 3)


def call(folder: Path, *more: str, most_bytes: int | None = None) -> subprocess.CompletedProcess:
    """With files that can grow no longer than that, as on a disk without room."""

    def limit() -> None:
        if most_bytes is not None:
            resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))

    command = [sys.executable, "-m", "aerodrake", *ARGV, *more]
    return subprocess.run(
        command, cwd=folder, preexec_fn=limit, capture_output=True, text=True, timeout=600
    )


def test_a_disk_that_is_full_leaves_no_row(tmp_path):
    """Large enough for the sweep's folder, too small for a flight."""
    done = call(tmp_path, most_bytes=12_000)
    assert done.returncode == 1 and done.stdout == ""
    hint, said = done.stderr.splitlines()
    assert "0 of 2 trials are in swept; to go on: aerodrake sweep hover" in hint
    assert said.startswith("aerodrake: trial 0 could not be flown: ") and "File too large" in said
    assert [*read_rows(tmp_path / "swept")] == []
    assert call(tmp_path, "--resume").returncode == 0
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
