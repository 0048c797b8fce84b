"""The cache of machine code depends on all source files."""

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
    """Returns the result of `calls.g` in a new process.

    -B disables Python's bytecode cache, which does not detect a source of equal time and size.
    """
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


def test_changing_a_called_function_or_a_constant_recompiles(sources):
    assert run(sources) == 101
    before = machine_code(sources)
    assert before and run(sources) == 101 and machine_code(sources) == before
    (sources / "called.py").write_text(CALLED.format(20))
    assert run(sources) == 120
    old = (sources / "inner" / "number.py").stat().st_mtime
    (sources / "inner" / "number.py").write_text(NUMBER.format(200))
    os.utime(sources / "inner" / "number.py", (old, old))  # As of a restored file.
    assert run(sources) == 220
    assert len(machine_code(sources)) == len(before)


def test_the_cache_is_elsewhere_if_the_sources_are_read_only(sources, tmp_path, monkeypatch):
    elsewhere = tmp_path / "elsewhere"
    assert cache_folder(sources, elsewhere).parent == sources / "__pycache__"
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    folder = cache_folder(sources, elsewhere)
    assert folder.parent == elsewhere
    assert folder.name == cache_folder(sources, elsewhere).name


def test_the_folder_depends_on_the_content_of_the_sources(sources):
    first = cache_folder(sources, sources)
    assert cache_folder(sources, sources) == first
    (sources / "another.py").write_text("")
    assert cache_folder(sources, sources) != first
