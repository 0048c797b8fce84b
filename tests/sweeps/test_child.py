"""Children: they are called again, replaced, and end with whoever calls."""

import contextlib
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
import types
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from aerodrake.support.errors import ProcessDied
from aerodrake.sweeps import child
from aerodrake.sweeps.child import NeverBegan, apart, end_children


@pytest.fixture(autouse=True)
def _nobody_is_left():
    yield
    end_children()


def is_alive(pid: int) -> bool:
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def wait_until(condition) -> None:
    deadline = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.01)


def test_a_thread_calls_the_same_child_again():
    pids = {apart(os.getpid) for _ in range(3)}
    assert len(pids) == 1 and os.getpid() not in pids


def test_threads_have_children_of_their_own():
    barrier = threading.Barrier(2)

    def call(_: int) -> int:
        barrier.wait()
        return apart(os.getpid)

    with ThreadPoolExecutor(2) as executor:
        assert len(set(executor.map(call, range(2)))) == 2


def test_a_child_is_replaced_after_so_many_calls(monkeypatch):
    monkeypatch.setattr(child, "MOST_CALLS", 2)
    pids = [apart(os.getpid) for _ in range(5)]
    assert pids[0] == pids[1] != pids[2] == pids[3] != pids[4]
    assert not is_alive(pids[0]) and not is_alive(pids[2])


def test_what_it_raises_is_raised_here_and_it_lives_on():
    pid = apart(os.getpid)
    with pytest.raises(ValueError, match="invalid literal"):
        apart(int, "x")
    assert apart(os.getpid) == pid


def test_what_cannot_be_imported_there_is_raised_here(monkeypatch):
    module = types.ModuleType("nowhere")
    exec("def here():\n    return 1", module.__dict__)
    monkeypatch.setitem(sys.modules, "nowhere", module)
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        apart(module.here)
    assert apart(os.getpid)


@pytest.mark.parametrize(
    ("code", "cause"),
    [("import os; os._exit(3)", "exit code 3"), ("raise SystemExit(4)", "exit code 4")],
)
def test_one_that_dies_is_told_and_replaced(code, cause):
    pid = apart(os.getpid)
    with pytest.raises(ProcessDied, match=f"its process died of {cause}"):
        apart(exec, code)
    assert apart(os.getpid) != pid


def test_one_that_dies_before_it_begins_is_told_apart(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(NeverBegan, match="its process died of exit code 1 before it began"):
        apart(os.getpid)
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    with pytest.raises(FileNotFoundError):
        apart(os.getpid)


def test_killed_while_nobody_calls_it_is_replaced():
    pid = apart(os.getpid)
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not is_alive(pid))
    with contextlib.suppress(ProcessDied):  # Its threads may end a little later.
        apart(os.getpid)
    assert apart(os.getpid) != pid


def test_all_are_ended_at_once_whatever_they_do():
    with ThreadPoolExecutor(1) as executor:
        pid = executor.submit(apart, os.getpid).result()
        future = executor.submit(apart, time.sleep, 600)
        time.sleep(0.1)
        end_children()
        assert isinstance(future.exception(), ProcessDied | None)
        assert not is_alive(pid)


def test_children_end_with_their_parent_even_if_it_is_killed_and_they_fly():
    code = (
        "import os, time\n"
        "from aerodrake.sweeps.child import apart\n"
        "print(apart(os.getpid), flush=True)\n"
        "apart(time.sleep, 600)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid = int(parent.stdout.readline())
    assert is_alive(pid)
    parent.kill()
    parent.communicate(timeout=30)
    wait_until(lambda: not is_alive(pid))


def test_one_that_is_not_called_ends():
    code = (
        "from multiprocessing.connection import Pipe\n"
        "from aerodrake.sweeps import child\n"
        "child.IDLE_S = 0.05\n"
        "ours, theirs = Pipe()\n"
        "child.main(theirs)\n"
        "print('ended')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "ended\n")


def call_from_a_daemon(pipe) -> None:
    pipe.send((multiprocessing.current_process().daemon, apart(os.getpid), os.getpid()))


def test_a_daemon_may_have_one_as_well():
    """As the workers of a cluster are."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=call_from_a_daemon, args=[theirs], daemon=True)
    process.start()
    is_daemon, pid, parent = ours.recv()
    process.join()
    assert is_daemon and pid != parent
    wait_until(lambda: not is_alive(pid))
