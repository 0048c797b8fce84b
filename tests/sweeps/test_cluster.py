"""Sweeps on a Dask cluster of two worker processes on loopback."""

import json
import os
import signal
import socket
import sys
import time
from pathlib import Path

import pytest

from aerodrake.cli import main
from aerodrake.scenario.load import load_with_options
from aerodrake.support.errors import BadInput
from aerodrake.sweeps import cluster as module
from aerodrake.sweeps.cluster import cluster
from aerodrake.sweeps.folder import sweep_folder
from aerodrake.sweeps.loop import fly_trials
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS, TIMINGS
from aerodrake.sweeps.trial import fly_trial
from tests.plans import by_key

distributed = pytest.importorskip("distributed")

TRIALS = 6
CHANGES = [("--set", "settle_s=0.02"), ("--set", "duration=0.06")]
VARY = "wind.gust_m_s[0]=uniform(0, 2)"


@pytest.fixture(scope="module")
def scheduler(tmp_path_factory) -> str:
    """Address of a scheduler whose workers are daemons of a nanny, as `dask worker` starts them."""
    folder = tmp_path_factory.mktemp("dask")
    local = distributed.LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        host="127.0.0.1",
        dashboard_address=None,
        local_directory=str(folder),
        silence_logs=50,
    )
    with local:
        yield local.scheduler_address


@pytest.fixture(scope="module")
def plan() -> Plan:
    return Plan.make(load_with_options("hover", CHANGES), by_key([VARY]), TRIALS)


@pytest.fixture(scope="module")
def flown(plan) -> set[str]:
    return {json.dumps(fly_trial(plan.trial(i))[0]) for i in range(TRIALS)}


def rows(folder: Path) -> list[str]:
    return (folder / ROWS).read_text().splitlines()


def test_rows_equal_those_of_single_flights(scheduler, flown, tmp_path, capsys):
    out = tmp_path / "sweep"
    options = [word for change in CHANGES for word in change]
    options += ["--trials", str(TRIALS), "--vary", VARY, "--out", str(out), "--quiet"]
    assert main(["sweep", "hover", *options, "--scheduler", scheduler]) == 0
    assert set(rows(out)) == flown and len(rows(out)) == TRIALS
    timings = [json.loads(line) for line in (out / TIMINGS).read_text().splitlines()]
    assert len({timing["process"] for timing in timings}) == 2
    assert capsys.readouterr() == ("", "")


def test_a_killed_worker_does_not_change_the_rows(scheduler, plan, flown, tmp_path):
    with cluster(scheduler) as executor, sweep_folder(tmp_path / "s", plan, False) as folder:
        pid, killed = executor.submit(os.getpid).result(), []

        def progress(_):
            if not killed:
                os.kill(pid, signal.SIGKILL)
                killed.append(pid)

        fly_trials(folder, executor, progress)
        while True:  # Until its nanny has started another one.
            time.sleep(0.05)
            if len(executor._client.scheduler_info()["workers"]) == 2:
                break
    assert killed and len(rows(tmp_path / "s")) == TRIALS and set(rows(tmp_path / "s")) == flown


def test_a_worker_of_another_version_is_refused(scheduler, monkeypatch):
    monkeypatch.setattr(module, "__version__", "0.0.0")  # In this process only.
    expected = "scheduler: expected aerodrake 0.0.0 on worker tcp:.*got '"
    with pytest.raises(BadInput, match=expected), cluster(scheduler):
        pytest.fail("connected")


@pytest.mark.parametrize("address", ["nonsense", "", "tcp://127.0.0.1", "closed"])
def test_a_scheduler_that_does_not_respond_is_bad_input(address, monkeypatch, capsys):
    monkeypatch.setattr(module, "TIMEOUT_S", 0.5)
    if address == "closed":
        with socket.create_server(("127.0.0.1", 0)) as server:
            address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
    assert main(["sweep", "hover", "--trials", "1", "--quiet", "--scheduler", address]) == 2
    error = capsys.readouterr().err
    assert "scheduler: expected the address of a Dask scheduler" in error
    assert len(error.splitlines()) == 1


def test_a_missing_extra_is_bad_input(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    expected = r"scheduler: expected the extra \[cluster\]"
    with pytest.raises(BadInput, match=expected), cluster("tcp://127.0.0.1:8786"):
        pytest.fail("connected")
