"""A killed command leaves no corrupt file and no process, and the next call succeeds.

A few kills of `run` by default; `pytest --long tests/test_kill.py` kills all commands 50 times.
"""

import contextlib
import json
import random
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from aerodrake.learning.dataset import ARRAYS
from aerodrake.model.residual.checkpoint import load
from aerodrake.scenario.load import load_scenario

TINY = ["hover", "--set", "settle_s=0", "--set", "duration=0.2"]
COMMANDS = {
    "run": ["run", *TINY],
    "compare": ["compare", *TINY, "--variant", "integral", "--variant", "modified"],
    "train": ["train", "--quick"],
}
KILLS = {"run": (2, 20), "compare": (0, 15), "train": (0, 15)}
"""Number of kills by default, and with --long."""

CALL_S, CHILDREN_S = 600, 60
"""Time limits of a call, and of its children after a kill."""


def call(command: str, folder: Path) -> subprocess.Popen:
    """Starts a command in its own process group."""
    argv = [sys.executable, "-m", "aerodrake", *COMMANDS[command], "--quiet", "--out", "results"]
    pipe = subprocess.PIPE
    return subprocess.Popen(argv, cwd=folder, start_new_session=True, stdout=pipe, stderr=pipe)


def finish(command: str, folder: Path) -> float:
    """Runs a command to its end, without output, and returns the time that it takes in s."""
    start = time.monotonic()
    process = call(command, folder)
    output = process.communicate(timeout=CALL_S)
    assert (process.returncode, *output) == (0, b"", b"")
    assert [path.name for path in folder.iterdir()] == ["results"]
    hidden = [path for path in folder.rglob("*") if path.name.startswith(".")]
    assert not hidden
    return time.monotonic() - start


def kill(command: str, folder: Path, after_s: float) -> None:
    process = call(command, folder)
    with contextlib.suppress(subprocess.TimeoutExpired):
        process.wait(timeout=after_s)
    process.kill()
    process.communicate(timeout=CALL_S)
    wait_for_children(process.pid)


def wait_for_children(group: int) -> None:
    """Waits until all processes of a group have ended by themselves."""
    deadline = time.monotonic() + CHILDREN_S
    while any(members := [*running(group)]):
        assert time.monotonic() < deadline, f"left: {members}"
        time.sleep(0.05)


def running(group: int) -> Iterator[int]:
    """Yields the processes of a group that are not zombies."""
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, its_group = path.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                yield int(path.parent.name)


def check(folder: Path) -> None:
    """Reads every file except those in hidden folders completely."""
    for path in folder.rglob("*"):
        if path.is_dir() or any(p.startswith(".") for p in path.relative_to(folder).parts):
            continue
        content = path.read_bytes()
        if path.suffix == ".json":
            json.loads(content)
        elif path.suffix == ".npz":
            with np.load(path, allow_pickle=False) as arrays:
                assert [arrays[name].shape for name in arrays.files]
                assert set(ARRAYS) < set(arrays.files) or "time_s" in arrays.files
        elif path.suffix == ".yaml":
            load_scenario(str(path))
        elif path.suffix == ".png":
            assert content.startswith(b"\x89PNG") and content.endswith(b"IEND\xaeB`\x82")
        elif path.suffix == ".html":
            assert content.rstrip().endswith(b"</html>")
        elif path.suffix == ".pt":
            load(path, 6)
        else:
            pytest.fail(f"unexpected {path}")


@pytest.mark.parametrize("command", COMMANDS)
def test_killed_at_any_time(command, tmp_path, long):
    kills = KILLS[command][long]
    if not kills:
        pytest.skip("only with --long")
    rng = random.Random(command)
    # An earlier run to be replaced, and the duration of a run.
    whole_s = finish(command, tmp_path)
    for _ in range(kills):
        kill(command, tmp_path, rng.uniform(0.1, 1.05) * whole_s)
        check(tmp_path)
        assert (tmp_path / "results").exists() or list(tmp_path.glob(".*/old/results"))
    finish(command, tmp_path)
    check(tmp_path)


@pytest.mark.parametrize(("number", "times"), [(signal.SIGINT, 2), (signal.SIGTERM, 1)])
def test_an_interrupt_in_flight_writes_the_results(number, times, tmp_path):
    """One or two interrupts during the flight end it, and the results are written."""
    argv = ["run", "hover", "--set", "settle_s=0", "--duration", "3000", "--out", "results"]
    code = f"import signal, sys\nsignal.signal({int(number)}, signal.default_int_handler)\n"
    code += "from aerodrake.cli import main\nsys.exit(main(sys.argv[1:]))"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *argv], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    output = ""
    while not re.search(r"[1-9][0-9]*\.[0-9]/3000\.0 s", output):  # At least one second is flown.
        output += process.stderr.read(1)
    for _ in range(times):
        process.send_signal(number)
        time.sleep(0.02)
    _, output = process.communicate(timeout=CALL_S)
    assert process.returncode == 1 and "Traceback" not in output
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["exit_reason"] == "interrupted" and 1 <= summary["simulated_s"] < 3000
    check(tmp_path)
    assert len(list((tmp_path / "results").iterdir())) == 6


def test_an_interrupted_comparison_leaves_no_file_and_no_process(tmp_path, monkeypatch):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setenv("TMPDIR", str(temporary))
    process = call("compare", tmp_path)
    while not list(temporary.rglob("integral")):  # The first variant has begun.
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, output = process.communicate(timeout=CALL_S)
    assert process.returncode == 130 and output == b"aerodrake: interrupted\n"
    assert list(tmp_path.iterdir()) == [temporary]
    wait_for_children(process.pid)
    assert not list(temporary.rglob("integral"))
