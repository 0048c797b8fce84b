"""Station and coordinator as processes, over LCM. No test depends on wall time."""

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
"""Timeouts that no load of the machine exceeds."""

BEGUN = re.compile(rb"\| (?!0\.0/)[\d.]+/")
"""Progress bar after the start of the flight."""


@pytest.fixture
def url():
    """URL that no other test uses."""
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
    """Reads until the process prints that it waits."""
    for line in process.stdout:
        if b"waiting" in line:
            return
    raise AssertionError(process.stderr.read().decode())


def begins(process):
    """Reads until the progress bar shows that the flight has begun."""
    output = b""
    while not BEGUN.search(output):
        chunk = process.stderr.read1()
        assert chunk, output.decode()
        output += chunk


def test_two_processes_fly_and_write_the_folder_of_a_run(start, url, tmp_path):
    """The coordinator pauses for a while. The order of starts differs in `fly_over_lcm.py`."""
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


def test_a_coordinator_that_ends_leads_to_a_landing(start, url, tmp_path):
    """An interrupted coordinator prints its report; for the station it is dead."""
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
    assert re.search(r"no sample from the station for 0\.4 s, since [\d.]+ s", line)
    assert b" ticks, " in report


def test_different_scenarios_are_refused_at_both_ends(start, url, tmp_path):
    other = ["--set", "rates.mpc_period_s=0.04", "--set", "mpc.horizon=7"]
    ends = {
        "coordinator": start("run", *SHORT, "--quiet", "--lcm", url, "--out", tmp_path / "out"),
        "station": start("coordinator", *SHORT, "--quiet", "--lcm", url, *other),
    }
    for expected, process in ends.items():
        output, errors = process.communicate(timeout=300)
        problem = f"expected a {expected} of the same scenario, got one that differs in rates, mpc"
        assert errors.decode() == f"aerodrake: --lcm: {problem}\n"
        assert process.returncode == 2 and output == b""
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("command", ["run", "coordinator"])
def test_waiting_can_be_interrupted(url, tmp_path, monkeypatch, capsys, command):
    """The third update of the progress bar interrupts this process."""
    monkeypatch.chdir(tmp_path)
    updates = []

    def update(bar, step):
        updates.append(step)
        if len(updates) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(tqdm.tqdm, "update", update)
    assert main([command, *SHORT, "--lcm", url]) == 130
    output, errors = capsys.readouterr()
    assert "waiting" in output and updates == [0.0, 0.0, 0.0]
    assert "Traceback" not in errors and "aerodrake: interrupted" in errors
    assert not list(tmp_path.rglob("*.*"))


@pytest.mark.parametrize("command", ["run", "coordinator"])
def test_an_invalid_address_is_bad_input(tmp_path, monkeypatch, capsys, command):
    monkeypatch.chdir(tmp_path)
    assert main([command, *SHORT, "--quiet", "--lcm", "udpm://localhost"]) == 2
    output, errors = capsys.readouterr()
    assert output == "" and errors.startswith("aerodrake: --lcm: expected udpm://")
    assert errors.count("\n") == 1 and not list(tmp_path.iterdir())
