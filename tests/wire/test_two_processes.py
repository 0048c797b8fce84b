"""Station and coordinator as processes, over a wire of their own. No test looks at the clock."""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest
import tqdm

from aerodrake.cli import main

SHORT = ["hover", "--set", "settle_s=0.2", "--set", "duration=0.8"]
PATIENT = [
    *("--set", "supervisor.plan_ticks=1000"),
    *("--set", "supervisor.plan_lost_s=1000"),
    *("--set", "supervisor.attitude_lost_s=60"),
]
"""However busy the machine is, nobody gives up."""

BEGUN = re.compile(rb"\| (?!0\.0/)[\d.]+/")
"""In a progress bar."""


@pytest.fixture
def url():
    """An address that no other test has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("", 0))
        return f"udpm://239.255.76.67:{free.getsockname()[1]}?ttl=0"


@pytest.fixture
def start():
    processes = []

    def start(*command):
        process = subprocess.Popen(
            [sys.executable, "-u", "-m", "aerodrake", *map(str, command)],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        processes.append(process)
        return process

    yield start
    for process in processes:
        process.kill()
        process.communicate()


def waits(process):
    """Reads until it says that it does."""
    for line in process.stdout:
        if b"waiting" in line:
            return
    raise AssertionError(process.stderr.read().decode())


def begins(process):
    """Reads until it says that the flight has begun."""
    said = b""
    while not BEGUN.search(said):
        came = process.stderr.read1()
        assert came, said.decode()
        said += came


def test_they_fly_whoever_is_held_up_and_leave_a_runs_folder(start, url, tmp_path):
    """The station first; the other order is that of `diagrams/fly_over_lcm.py`."""
    options = [*SHORT, *PATIENT, "--lcm", url]
    commands = {"station": ["run", *options, "--out", tmp_path / "out"]}
    commands["coordinator"] = ["coordinator", *options]
    station = start(*commands["station"])
    waits(station)
    coordinator = start(*commands["coordinator"])
    begins(coordinator)
    coordinator.send_signal(signal.SIGSTOP)
    time.sleep(0.3)
    coordinator.send_signal(signal.SIGCONT)
    outputs = [process.communicate(timeout=300) for process in (station, coordinator)]
    assert (station.returncode, coordinator.returncode) == (0, 0), outputs
    assert b" ticks, " in outputs[1][0]
    names = {path.name for path in (tmp_path / "out").iterdir()}
    pages = {"tracking.png", "replay.html", "report.html"}
    assert names == {"summary.json", "log.npz", "scenario.yaml", *pages}
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["exit_reason"] == "completed"
    assert summary["wall_s"] > 0.99 * summary["simulated_s"] == 0.99
    assert summary["mpc"]["missed"] >= 10 and summary["mpc"]["ticks"] > 10
    assert summary["mpc"]["ticks"] + summary["mpc"]["missed"] == 50
    assert summary["error"]["max_m"] < 0.01


def test_a_coordinator_that_ends_is_an_mpc_without_an_answer(start, url, tmp_path):
    """Interrupted, it says what it did; to the station that is as if it were killed."""
    options = [*SHORT, "--set", "supervisor.plan_lost_s=0.2", "--lcm", url]
    station = start("run", *options, "--out", tmp_path / "out", "--duration", 1)
    coordinator = start("coordinator", *options)
    begins(coordinator)
    coordinator.send_signal(signal.SIGINT)
    report, errors = coordinator.communicate(timeout=300)
    assert coordinator.returncode == 130
    assert re.search(rb"[\d.]+ s, \d+ ticks, \d+ missed, ", report)
    assert b"Traceback" not in errors and b"aerodrake: interrupted" in errors
    table, errors = station.communicate(timeout=300)
    assert station.returncode == 1, errors
    assert b"Traceback" not in errors
    assert b"MPC ticks missed" in table
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    # Hover is 1.2 m above the ground, which a second of descent do not reach.
    assert (summary["exit_reason"], summary["exit_cause"][:9]) == ("descend", "plan_lost")
    assert summary["simulated_s"] == 1.2


def test_a_killed_station_ends_its_coordinator(start, url, tmp_path):
    station = start("run", *SHORT, "--duration", 60, "--lcm", url, "--out", tmp_path / "out")
    coordinator = start("coordinator", *SHORT, "--lcm", url)
    begins(coordinator)
    station.send_signal(signal.SIGKILL)
    report, errors = coordinator.communicate(timeout=300)
    assert coordinator.returncode == 1, errors
    (line,) = [line for line in errors.decode().splitlines() if line.startswith("aerodrake: ")]
    assert re.search(r"no sample of the station for 0\.4 s, since [\d.]+ s", line)
    assert b" ticks, " in report


def test_two_scenarios_are_found_out_at_both_ends(start, url, tmp_path):
    other = ["--set", "rates.mpc_period_s=0.04", "--set", "mpc.horizon=7"]
    ends = {
        "coordinator": start("run", *SHORT, "--quiet", "--lcm", url, "--out", tmp_path / "out"),
        "station": start("coordinator", *SHORT, "--quiet", "--lcm", url, *other),
    }
    for expected, process in ends.items():
        said, errors = process.communicate(timeout=300)
        problem = f"expected a {expected} of the same scenario, got one that differs in rates, mpc"
        assert errors.decode() == f"aerodrake: --lcm: {problem}\n"
        assert process.returncode == 2 and said == b""
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["run", "coordinator"])
def test_who_waits_can_be_interrupted(url, tmp_path, monkeypatch, capsys, command):
    """In this process, the third time that it looks up: else it would wait for ever."""
    monkeypatch.chdir(tmp_path)
    looks = []

    def update(bar, step):
        looks.append(step)
        if len(looks) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(tqdm.tqdm, "update", update)
    assert main([command, *SHORT, "--lcm", url]) == 130
    said, errors = capsys.readouterr()
    assert "waiting" in said and looks == [0.0, 0.0, 0.0]
    assert "Traceback" not in errors and "aerodrake: interrupted" in errors
    assert not list(tmp_path.rglob("*.*"))


@pytest.mark.parametrize("command", ["run", "coordinator"])
def test_an_address_that_is_none(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    assert main([command, *SHORT, "--quiet", "--lcm", "udpm://localhost"]) == 2
    said, errors = capsys.readouterr()
    assert said == "" and errors.startswith("aerodrake: --lcm: expected udpm://")
    assert errors.count("\n") == 1 and not list(tmp_path.iterdir())
