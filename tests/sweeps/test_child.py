"""Children are reused, replaced, and end with their parent."""

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
from aerodrake.sweeps.child import DiedBeforeCall, call_in_child, kill_children


@pytest.fixture(autouse=True)
def _no_child_is_left():
    yield
    kill_children()


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


def test_a_thread_reuses_its_child():
    pids = {call_in_child(os.getpid) for _ in range(3)}
    assert len(pids) == 1 and os.getpid() not in pids


def test_threads_have_children_of_their_own():
    barrier = threading.Barrier(2)

    def call(_: int) -> int:
        barrier.wait()
        return call_in_child(os.getpid)

    with ThreadPoolExecutor(2) as executor:
        assert len(set(executor.map(call, range(2)))) == 2


def test_a_child_is_replaced_after_a_number_of_calls(monkeypatch):
    monkeypatch.setattr(child, "MOST_CALLS", 2)
    pids = [call_in_child(os.getpid) for _ in range(5)]
    assert pids[0] == pids[1] != pids[2] == pids[3] != pids[4]
    assert not is_alive(pids[0]) and not is_alive(pids[2])


def test_errors_are_raised_in_the_parent_and_the_child_is_reused():
    pid = call_in_child(os.getpid)
    with pytest.raises(ValueError, match="invalid literal"):
        call_in_child(int, "x")
    assert call_in_child(os.getpid) == pid


def test_import_errors_of_the_child_are_raised_in_the_parent(monkeypatch):
    module = types.ModuleType("nowhere")
    exec("def here():\n    return 1", module.__dict__)
    monkeypatch.setitem(sys.modules, "nowhere", module)
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        call_in_child(module.here)
    assert call_in_child(os.getpid)


@pytest.mark.parametrize(
    ("code", "cause"),
    [("import os; os._exit(3)", "exit code 3"), ("raise SystemExit(4)", "exit code 4")],
)
def test_a_child_that_dies_raises_and_is_replaced(code, cause):
    pid = call_in_child(os.getpid)
    with pytest.raises(ProcessDied, match=f"its process died of {cause}"):
        call_in_child(exec, code)
    assert call_in_child(os.getpid) != pid


def test_a_child_that_dies_before_the_call_raises_its_own_error(monkeypatch):
    monkeypatch.setattr(sys, "executable", "/bin/false")
    with pytest.raises(DiedBeforeCall, match="its process died of exit code 1 before the call"):
        call_in_child(os.getpid)
    monkeypatch.setattr(sys, "executable", "/no/such/python")
    with pytest.raises(FileNotFoundError):
        call_in_child(os.getpid)


def test_a_child_killed_between_calls_is_replaced():
    pid = call_in_child(os.getpid)
    os.kill(pid, signal.SIGKILL)
    wait_until(lambda: not is_alive(pid))
    with contextlib.suppress(ProcessDied):  # Its threads may end a little later.
        call_in_child(os.getpid)
    assert call_in_child(os.getpid) != pid


def test_all_children_can_be_killed_during_calls():
    with ThreadPoolExecutor(1) as executor:
        pid = executor.submit(call_in_child, os.getpid).result()
        future = executor.submit(call_in_child, time.sleep, 600)
        time.sleep(0.1)
        kill_children()
        assert isinstance(future.exception(), ProcessDied | None)
        assert not is_alive(pid)


def test_children_end_with_their_parent_even_if_it_is_killed_during_a_call():
    code = (
        "import os, time\n"
        "from aerodrake.sweeps.child import call_in_child\n"
        "print(call_in_child(os.getpid), flush=True)\n"
        "call_in_child(time.sleep, 600)\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    pid = int(parent.stdout.readline())
    assert is_alive(pid)
    parent.kill()
    parent.communicate(timeout=30)
    wait_until(lambda: not is_alive(pid))


def test_an_idle_child_ends():
    code = (
        "from multiprocessing.connection import Pipe\n"
        "from aerodrake.sweeps import child\n"
        "child.IDLE_S = 0.05\n"
        "local, remote = Pipe()\n"
        "child.main(remote)\n"
        "print('ended')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "ended\n")


def call_from_a_daemon(pipe) -> None:
    pipe.send((multiprocessing.current_process().daemon, call_in_child(os.getpid), os.getpid()))


def test_a_daemon_can_have_a_child():
    """Workers of a cluster are daemons."""
    context = multiprocessing.get_context("spawn")
    local, remote = context.Pipe()
    process = context.Process(target=call_from_a_daemon, args=[remote], daemon=True)
    process.start()
    is_daemon, pid, parent = local.recv()
    process.join()
    assert is_daemon and pid != parent
    wait_until(lambda: not is_alive(pid))
