"""The cache of machine code depends on all source files."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from numba import config

from aerodrake.support import cache_folders, compiled
from aerodrake.support.compiled import CacheFolders

NUMBER = "NUMBER = {}\n"
CALLED = (
    "from aerodrake.support.compiled import compiled\nfrom inner.number import NUMBER\n"
    "@compiled\ndef f():\n    return {} + NUMBER\n"
)
CALLS = (
    "from aerodrake.support.compiled import compiled\nfrom called import f\n"
    "@compiled\ndef g():\n    return f()\n"
)
RUN = """
from pathlib import Path
from aerodrake.support import compiled
compiled.CACHE = compiled.CacheFolders(Path().absolute())
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


@pytest.fixture
def usual(tmp_path, monkeypatch):
    """Function that sets NUMBA_CACHE_DIR, the user's cache and the folders that are writable."""

    def usual(numba: str, user: Path | None, *writable: Path) -> None:
        monkeypatch.setattr(config, "CACHE_DIR", numba)
        monkeypatch.setattr(compiled, "user_folder", lambda *names: user)
        monkeypatch.setattr(compiled, "private_folder", lambda: tmp_path / "temporary")
        monkeypatch.setattr(cache_folders, "is_writable", lambda folder: folder in writable)

    return usual


def test_folders_in_the_order_of_their_preference(sources, usual, tmp_path):
    beside, user = sources / "__pycache__", tmp_path / "user"
    own, temporary = user / "aerodrake", tmp_path / "temporary"
    for numba, home, writable, writes, reads in (
        ("", user, (beside, own), beside, [beside, own]),
        ("", user, (own,), own, [beside, own]),
        ("", user, (), temporary, [beside, own, temporary]),
        ("", None, (), temporary, [beside, temporary]),
        ("/numba", user, (beside, own, Path("/numba")), Path("/numba"), [Path("/numba")]),
        ("/numba", user, (beside, own), temporary, [Path("/numba"), temporary]),
    ):
        usual(numba, home, *writable)
        folders = CacheFolders(sources)
        assert folders.writes.parent == writes
        assert [folder.parent for folder in folders.reads] == reads
        assert {folder.name for folder in folders.reads} == {folders.writes.name}
        assert bool(folders.note) == (writes == temporary)
        if folders.note:
            assert f"kept in {temporary}, since {reads[0]} " in folders.note


def test_without_any_folder_the_note_says_so(sources, usual, monkeypatch):
    usual("", None)
    monkeypatch.setattr(compiled, "private_folder", lambda: None)
    folders = CacheFolders(sources)
    assert folders.writes is None and "compiled anew in each process" in folders.note


def test_old_folders_are_deleted_beside_the_sources_alone(sources, usual, tmp_path):
    """Other installations may use the others."""
    for parent in (sources / "__pycache__", tmp_path / "numba"):
        (parent / "compiled-old").mkdir(parents=True)
        usual(str(parent) if parent.name == "numba" else "", None, parent)
        CacheFolders(sources)
        assert (parent / "compiled-old").exists() == (parent.name == "numba")


def test_the_folder_depends_on_the_content_of_the_sources(sources):
    first = CacheFolders(sources).writes
    assert CacheFolders(sources).writes == first
    (sources / "another.py").write_text("")
    assert CacheFolders(sources).writes != first


def test_an_unknown_user_without_a_home_has_compiled_code(sources, tmp_path):
    """The user may read everything and write nothing but temporary files."""
    if os.getuid() != 0 or not shutil.which("setpriv"):
        pytest.skip("needs root and setpriv, to become another user")
    shared = tmp_path / "shared"
    shared.mkdir()
    shared.chmod(0o777)
    rights = "-all,+dac_read_search"
    user = ["setpriv", "--reuid=54321", "--regid=54321", "--clear-groups"]
    user += [f"--inh-caps={rights}", f"--ambient-caps={rights}", f"--bounding-set={rights}"]
    command = [*user, sys.executable, "-B", "-c", RUN + "print(compiled.CACHE.note)"]
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(shared)}
    done = subprocess.run(command, cwd=sources, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""
    value, note = done.stdout.splitlines()
    assert value == "101" and "shared/aerodrake-54321, since" in note
    assert len(machine_code(shared)) == 2
