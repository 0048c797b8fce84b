"""Killed at any time: no corrupt file, nobody left behind, and the next call works.

A few kills of `run` by default; 50 of all three by `pytest --long tests/test_kill.py`.
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
"""By default, and of all."""

CALL_S, CHILDREN_S = 600, 60
"""Nothing here takes as long."""


def call(command: str, folder: Path) -> subprocess.Popen:
    """In a group of its own, to which its children belong."""
    argv = [sys.executable, "-m", "aerodrake", *COMMANDS[command], "--quiet", "--out", "results"]
    pipe = subprocess.PIPE
    return subprocess.Popen(argv, cwd=folder, start_new_session=True, stdout=pipe, stderr=pipe)


def finish(command: str, folder: Path) -> float:
    """Calls it undisturbed; how long that took, in s. Nobody says a word, not even Drake."""
    start = time.monotonic()
    process = call(command, folder)
    said = process.communicate(timeout=CALL_S)
    assert (process.returncode, *said) == (0, b"", b"")
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
    """Until all of a group have ended, which they are to do by themselves."""
    deadline = time.monotonic() + CHILDREN_S
    while any(members := [*living(group)]):
        assert time.monotonic() < deadline, f"left: {members}"
        time.sleep(0.05)


def living(group: int) -> Iterator[int]:
    """The processes of a group that are not dead, if perhaps not buried."""
    for place in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, its_group = place.read_text().rpartition(")")[2].split()[:3]
            if int(its_group) == group and state != "Z":
                yield int(place.parent.name)


def check(folder: Path) -> None:
    """Each file that has its own name can be read to its end."""
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
        pytest.skip("by --long only")
    rng = random.Random(command)
    # An earlier run, to be replaced; and how long one takes.
    whole_s = finish(command, tmp_path)
    for _ in range(kills):
        kill(command, tmp_path, rng.uniform(0.1, 1.05) * whole_s)
        check(tmp_path)
        assert (tmp_path / "results").exists() or list(tmp_path.glob(".*/old/results"))
    finish(command, tmp_path)
    check(tmp_path)


@pytest.mark.parametrize(("number", "times"), [(signal.SIGINT, 2), (signal.SIGTERM, 1)])
def test_interrupted_in_flight_it_writes_what_it_has(number, times, tmp_path):
    """However often it is asked to hurry: here twice at most, while it flies."""
    argv = ["run", "hover", "--set", "settle_s=0", "--duration", "3000", "--out", "results"]
    code = f"import signal, sys\nsignal.signal({int(number)}, signal.default_int_handler)\n"
    code += "from aerodrake.cli import main\nsys.exit(main(sys.argv[1:]))"
    process = subprocess.Popen(
        [sys.executable, "-c", code, *argv], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    said = ""
    while not re.search(r"[1-9][0-9]*\.[0-9]/3000\.0 s", said):  # In flight for a second.
        said += process.stderr.read(1)
    for _ in range(times):
        process.send_signal(number)
        time.sleep(0.02)
    _, said = process.communicate(timeout=CALL_S)
    assert process.returncode == 1 and "Traceback" not in said
    summary = json.loads((tmp_path / "results" / "summary.json").read_text())
    assert summary["exit_reason"] == "interrupted" and 1 <= summary["simulated_s"] < 3000
    check(tmp_path)
    assert len(list((tmp_path / "results").iterdir())) == 6


def test_interrupted_a_comparison_leaves_nothing_and_nobody(tmp_path):
    process = call("compare", tmp_path)
    while not list(tmp_path.glob(".aerodrake-*/new/results/*")):  # One is being flown.
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=CALL_S)
    assert process.returncode == 130 and said == b"aerodrake: interrupted\n"
    assert list(tmp_path.iterdir()) == []
    wait_for_children(process.pid)
