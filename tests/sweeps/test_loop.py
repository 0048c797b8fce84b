"""Sweeps: rows do not depend on the executor or on processes that die."""

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path

import pytest

from aerodrake.cli import main
from aerodrake.scenario.load import load_with_options
from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps import loop as module
from aerodrake.sweeps.folder import read_rows, sweep_folder
from aerodrake.sweeps.loop import fly_trials, processes
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS, TIMINGS
from aerodrake.sweeps.trial import fly_trial
from tests.in_this_process import call_in_this_process
from tests.plans import by_key

TRIALS = 6
VARY = ["wind.gust_m_s[0]=uniform(0, 2)", "mpc.horizon=choice(10, 15)"]
CHANGES = ["settle_s=0.02", "duration=0.08", "sensors.position_noise_m=0.001"]
OPTIONS = [
    *("hover", "--trials", str(TRIALS)),
    *(word for text in VARY for word in ("--vary", text)),
    *(word for text in CHANGES for word in ("--set", text)),
]


@pytest.fixture(scope="module")
def plan() -> Plan:
    scenario = load_with_options("hover", [("--set", change) for change in CHANGES])
    return Plan.make(scenario, by_key(VARY), TRIALS)


@pytest.fixture(scope="module")
def flown(plan) -> dict[int, str]:
    """Rows of single flights in this process, by trial."""
    return {i: json.dumps(fly_trial(plan.trial(i))[0]) for i in range(TRIALS)}


@pytest.fixture
def _without_children(monkeypatch):
    """Flies trials in this process, for tests that do not depend on children."""
    monkeypatch.setattr(module, "call_in_child", call_in_this_process)


def rows(folder: Path) -> dict[int, str]:
    lines = (folder / ROWS).read_text().splitlines()
    by_trial = {json.loads(line)["trial"]: line for line in lines}
    assert len(by_trial) == len(lines)
    return by_trial


def children(pid: int) -> list[int]:
    """Returns the child processes of another process that execute calls."""
    pids = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == pid and b"aerodrake.sweeps.child" in (folder / "cmdline").read_bytes():
                pids.append(int(folder.name))
        except OSError:
            continue
    return pids


def wait_until(condition) -> None:
    deadline = time.monotonic() + 120
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def is_alive(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def fly(plan: Plan, folder: Path, executor: Executor, progress=lambda row: None) -> None:
    with sweep_folder(folder, plan, resumes=False) as opened:
        fly_trials(opened, executor, progress)


def call(folder: Path, *more: str) -> subprocess.Popen:
    argv = [sys.executable, "-m", "aerodrake", "sweep", *OPTIONS, "--out", str(folder), *more]
    return subprocess.Popen(argv, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


# Executors.


def test_rows_of_two_processes_equal_those_of_single_flights(flown, tmp_path, capsys):
    out = tmp_path / "sweep"
    assert main(["sweep", *OPTIONS, "--jobs", "2", "--out", str(out), "--quiet"]) == 0
    assert rows(out) == flown and capsys.readouterr().out == ""
    timings = [json.loads(line) for line in (out / TIMINGS).read_text().splitlines()]
    assert sorted(timing["trial"] for timing in timings) == [*range(TRIALS)]
    assert len({timing["process"] for timing in timings}) == 2
    wait_until(lambda: not children(os.getpid()))  # A killed process frees its memory first.


@pytest.mark.usefixtures("_without_children")
def test_the_number_of_submitted_trials_is_bounded(plan, tmp_path, monkeypatch):
    class Slow(ThreadPoolExecutor):
        waiting = most = 0

        def submit(self, function, *arguments):
            self.waiting += 1
            self.most = max(self.most, self.waiting)
            return super().submit(function, complete, arguments[-1])

    executor = Slow(1)

    def progress(_):
        executor.waiting -= 1

    monkeypatch.setattr(module, "MOST_IN_FLIGHT", 3)
    with executor:
        fly(plan, tmp_path / "sweep", executor, progress)
    assert executor.most == 3 and len(rows(tmp_path / "sweep")) == TRIALS


def complete(trial):
    return {**trial.header(), "exit_reason": "completed"}, {"trial": trial.index}


# Processes that die.


def test_a_trial_whose_process_is_killed_is_flown_again(plan, flown, tmp_path):
    killed = []

    def progress(_):
        if not killed:
            killed.extend(children(os.getpid()))
            os.kill(killed[0], signal.SIGKILL)

    with processes(1) as executor:
        fly(plan, tmp_path / "sweep", executor, progress)
    timings = (tmp_path / "sweep" / TIMINGS).read_text().splitlines()
    assert len({json.loads(line)["process"] for line in timings}) == 2 and len(killed) == 1
    assert rows(tmp_path / "sweep") == flown


def die(trial):
    if trial.index == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return complete(trial)


def test_a_trial_that_kills_its_process_is_recorded_as_failed(plan, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "fly_trial", die)
    monkeypatch.setattr(module, "MOST_DEATHS", 2)
    with processes(1) as executor:
        fly(plan, tmp_path / "sweep", executor)
    recorded = {row["trial"]: row for row in read_rows(tmp_path / "sweep")}
    assert len(recorded) == TRIALS
    failed = recorded.pop(1)
    assert failed == {
        **plan.trial(1).header(),
        "exit_reason": "failed",
        "exit_cause": "ProcessDied: its process died of SIGKILL",
    }
    assert {row["exit_reason"] for row in recorded.values()} == {"completed"}


def test_an_executor_that_fails_is_reported(plan, tmp_path):
    class Gone(Executor):
        def submit(self, *_):
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future

    with pytest.raises(ProcessDied, match="the executor failed"):
        fly(plan, tmp_path / "sweep", Gone())
    assert rows(tmp_path / "sweep") == {}


def test_a_sweep_killed_at_any_time_can_be_resumed(flown, tmp_path, long):
    out = tmp_path / "sweep"
    process = call(out, "--jobs", "1")
    for enough in (0, 1, 1, 2, 4, 5) if long else (2,):
        wait_until(lambda enough=enough: (out / ROWS).exists() and len(rows_now(out)) >= enough)
        helpers = children(process.pid)
        process.kill()
        process.communicate()
        wait_until(lambda helpers=helpers: not any(is_alive(pid) for pid in helpers))
        assert not (out / Plan.files.summary).exists()
        process = call(out, "--jobs", "1", "--resume")
    output, error = process.communicate(timeout=120)
    assert process.returncode == 0 and "Traceback" not in error
    assert rows(out) == flown and f"{TRIALS} trials, {TRIALS} completed" in output
    assert json.loads((out / Plan.files.summary).read_text())["endings"] == {"completed": TRIALS}


def rows_now(folder: Path) -> list[bytes]:
    """Returns the rows of a running sweep."""
    return (folder / ROWS).read_bytes().splitlines()


def test_an_interrupted_sweep_ends_at_once_and_prints_how_to_resume(tmp_path):
    out = tmp_path / "my sweep"
    code = "import signal, sys\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
    code += "from aerodrake.cli import main\nsys.exit(main(sys.argv[1:]))"
    argv = ["sweep", "hover", "--trials", "2", "--vary", "duration=choice(3000, 3001)", "--quiet"]
    process = subprocess.Popen(
        [sys.executable, "-c", code, *argv, "--jobs", "1", "--out", str(out)],
        stderr=subprocess.PIPE,
        text=True,
    )
    wait_until(lambda: children(process.pid))
    helpers = children(process.pid)
    process.send_signal(signal.SIGINT)
    _, error = process.communicate(timeout=30)
    assert process.returncode == 130
    first, last = error.splitlines()
    assert last == "aerodrake: interrupted"
    head, _, command = first.partition("; continue with: ")
    assert head == f"aerodrake: 0 of 2 trials are in {out}"
    words = shlex.split(command)
    assert words[:3] == ["aerodrake", "sweep", "hover"] and words[-3:] == [
        "--resume", "--out", str(out)
    ]  # fmt: skip
    assert words[words.index("--vary") + 1] == "duration=choice(3000, 3001)"
    wait_until(lambda: not any(is_alive(pid) for pid in helpers))
    assert not (out / Plan.files.summary).exists()


@pytest.mark.usefixtures("_without_children")
def test_a_finished_sweep_can_be_resumed_with_more_trials(flown, tmp_path):
    out, quiet = str(tmp_path / "sweep"), ["--quiet", "--jobs", "1"]
    fewer = ["2" if word == str(TRIALS) else word for word in OPTIONS]
    assert main(["sweep", *fewer, "--out", out, *quiet]) == 0
    assert main(["sweep", *OPTIONS, "--out", out, "--resume", *quiet]) == 0
    assert rows(tmp_path / "sweep") == flown
