"""Machine code that others' sources have outdated is not run."""

import os
import subprocess
import sys
from pathlib import Path

from aerodrake.compiled import forget_stale, is_cold

CALLED = "from numba import njit\n@njit(cache=True)\ndef f():\n    return {}\n"
CALLS = (
    "from numba import njit\nfrom called import f\n@njit(cache=True)\ndef g():\n    return f()\n"
)
RUN = """
from pathlib import Path
from aerodrake.compiled import forget_stale
forget_stale(Path())
from calls import g
print(g())
"""


def run(folder: Path) -> int:
    """What `calls.g` returns in a process of its own."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    environment.pop("NUMBA_CACHE_DIR", None)
    done = subprocess.run(
        [sys.executable, "-c", RUN], cwd=folder, env=environment, capture_output=True, check=True
    )
    return int(done.stdout)


def test_a_change_of_what_is_called_is_noticed(tmp_path):
    (tmp_path / "called.py").write_text(CALLED.format(1))
    (tmp_path / "calls.py").write_text(CALLS)
    assert run(tmp_path) == 1
    (tmp_path / "called.py").write_text(CALLED.format(20))
    assert run(tmp_path) == 20


def test_what_is_older_than_a_compiled_source_goes_and_the_rest_stays(tmp_path):
    cache = tmp_path / "__pycache__"
    cache.mkdir()
    times = {
        "old.f-1.py311.nbi": 10,
        "new.g-1.py311.nbi": 30,
        "gone.h-1.py311.nbi": 30,
        "old.py": 5,
        "new.py": 20,
        "not_compiled.py": 40,
    }
    for name, time in times.items():
        path = (cache if name.endswith("nbi") else tmp_path) / name
        path.touch()
        os.utime(path, (time, time))
    forget_stale(tmp_path)
    assert {path.name for path in cache.iterdir()} == {"new.g-1.py311.nbi", "gone.h-1.py311.nbi"}


def test_without_a_cache_there_is_nothing_to_forget(tmp_path):
    forget_stale(tmp_path)
    assert not list(tmp_path.iterdir())


def test_it_is_cold_until_something_is_compiled(tmp_path):
    (tmp_path / "called.py").write_text(CALLED.format(1))
    (tmp_path / "calls.py").write_text(CALLS)
    assert is_cold(tmp_path)
    run(tmp_path)
    assert not is_cold(tmp_path)
    tmp_path.chmod(0o500)
    try:
        assert not is_cold(tmp_path / "nowhere")  # Machine code is kept elsewhere then.
    finally:
        tmp_path.chmod(0o700)
