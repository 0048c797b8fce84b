"""Machine code that any of the sources has outdated is not run, nor kept."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from aerodrake.support.compiled import cache_folder

NUMBER = "NUMBER = {}\n"
CALLED = (
    "from numba import njit\nfrom inner.number import NUMBER\n"
    "@njit(cache=True)\ndef f():\n    return {} + NUMBER\n"
)
CALLS = (
    "from numba import njit\nfrom called import f\n@njit(cache=True)\ndef g():\n    return f()\n"
)
RUN = """
from pathlib import Path
from numba import config
from aerodrake.support.compiled import cache_folder
config.CACHE_DIR = str(cache_folder(Path(), Path("elsewhere")))
from calls import g
print(g())
"""


@pytest.fixture
def sources(tmp_path) -> Path:
    """A function that calls one of another file, which reads a constant of a sub-folder's file."""
    (tmp_path / "inner").mkdir()
    (tmp_path / "inner" / "number.py").write_text(NUMBER.format(100))
    (tmp_path / "called.py").write_text(CALLED.format(1))
    (tmp_path / "calls.py").write_text(CALLS)
    return tmp_path


def run(folder: Path) -> int:
    """What `calls.g` returns in a process of its own, without Python's bytecode: that of a source
    of the same time and size would do for it."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-B", "-c", RUN],
        cwd=folder,
        env=environment,
        capture_output=True,
        check=True,
    )
    return int(done.stdout)


def machine_code(folder: Path) -> set[str]:
    return {str(path) for path in folder.rglob("*.nbc")}


def test_a_change_of_what_is_called_or_of_a_number_is_noticed(sources):
    assert run(sources) == 101
    before = machine_code(sources)
    assert before and run(sources) == 101 and machine_code(sources) == before
    (sources / "called.py").write_text(CALLED.format(20))
    assert run(sources) == 120
    old = (sources / "inner" / "number.py").stat().st_mtime
    (sources / "inner" / "number.py").write_text(NUMBER.format(200))
    os.utime(sources / "inner" / "number.py", (old, old))  # As restored files have it.
    assert run(sources) == 220
    assert len(machine_code(sources)) == len(before)


def test_where_nothing_can_be_written_it_is_kept_elsewhere(sources, tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    assert cache_folder(sources, elsewhere).parent == sources / "__pycache__"
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    folder = cache_folder(sources, elsewhere)
    assert folder.parent == elsewhere
    assert folder.name == cache_folder(sources, elsewhere).name


def test_folders_differ_by_what_the_sources_say(sources):
    first = cache_folder(sources, sources)
    assert cache_folder(sources, sources) == first
    (sources / "another.py").write_text("")
    assert cache_folder(sources, sources) != first
