"""Files of machine code may be damaged, missing, of another machine, or not writable."""

import os
from pathlib import Path
from random import Random

import numpy as np
import pytest
from numba import njit
from numba.core.codegen import JITCPUCodegen

from aerodrake.support import machine_code
from aerodrake.support.machine_code import MachineCode
from tests.room import room_for


def add(x, y):
    return x + y


def make(*reads: Path, writes: Path | None = None):
    """Returns the compiled `add`, with machine code in the first of the folders by default."""
    function = njit(add)
    function._cache = MachineCode(add, reads, writes or reads[0])
    return function


def is_loaded(*folders: Path, **others) -> bool:
    """Returns True if a new process would find the code of `add(1.0, 2)`."""
    function = make(*folders, **others)
    assert function(1.0, 2) == 3.0
    return sum(function.stats.cache_hits.values()) == 1


@pytest.fixture(scope="module")
def content(tmp_path_factory) -> bytes:
    folder = tmp_path_factory.mktemp("intact")
    assert not is_loaded(folder)
    return only_file(folder).read_bytes()


@pytest.fixture
def file(tmp_path, content) -> Path:
    """The only file of a cache, intact."""
    assert not is_loaded(tmp_path)
    return only_file(tmp_path)


def only_file(folder: Path) -> Path:
    (path,) = folder.iterdir()  # No temporary file is left either.
    return path


def can_load(file: Path) -> bool:
    function = njit(add)
    cache = MachineCode(add, [file.parent], None)
    signature = tuple(map(function.typeof_pyval, (1.0, 2)))
    return cache.load_overload(signature, function.targetctx) is not None


def test_code_is_loaded_again(file):
    assert can_load(file) and is_loaded(file.parent)


def test_any_damage_is_detected(file):
    """Truncated at any place, bytes changed at any place, appended, or of another file."""
    content = file.read_bytes()
    random = Random(0)
    lengths = {0, 1, 31, 32, 33, len(content) - 1, *random.choices(range(len(content)), k=20)}
    damaged = [content[:length] for length in lengths]
    for place in {0, 31, 32, len(content) - 1, *random.choices(range(len(content)), k=20)}:
        damaged.append(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
    damaged += [content + b"\0", b"\x80\x05", bytes(len(content)), random.randbytes(99)]
    for other in damaged:
        file.write_bytes(other)
        assert not can_load(file)
    file.write_bytes(content)
    assert can_load(file)


def test_a_damaged_file_is_replaced(file, content):
    file.write_bytes(content[:-100])
    assert not is_loaded(file.parent)
    assert only_file(file.parent) == file and is_loaded(file.parent)


def test_a_folder_or_a_dangling_link_in_the_place_of_a_file(file):
    file.unlink()
    file.symlink_to("nowhere")
    assert not is_loaded(file.parent)
    for path in (file.with_name("nowhere"), file):
        path.unlink(missing_ok=True)
    file.mkdir()
    assert not is_loaded(file.parent) and file.is_dir()


def test_a_file_of_another_signature_is_not_taken(file):
    function = make(file.parent)
    assert function(np.ones(2), 2.0).tolist() == [3.0, 3.0]
    (other,) = {*file.parent.iterdir()} - {file}
    other.replace(file)
    assert not can_load(file)


def test_code_of_another_version_or_processor_is_kept_and_not_taken(file, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(machine_code, "VERSIONS", ("0.1", *machine_code.VERSIONS[1:]))
        assert not is_loaded(file.parent) and is_loaded(file.parent)
    with monkeypatch.context() as patch:
        patch.setattr(JITCPUCodegen, "magic_tuple", lambda self: ("riscv64", "generic", ""))
        assert not is_loaded(file.parent) and is_loaded(file.parent)
    assert is_loaded(file.parent) and len(list(file.parent.iterdir())) == 3


def test_processes_that_start_at_the_same_time_do_not_exchange_signatures(tmp_path):
    one, other = make(tmp_path), make(tmp_path)
    assert one(1, 2) == 3 and other(1.5, 2.5) == 4.0  # Neither has read the other's file.
    again = make(tmp_path)
    assert again(1.5, 2.5) == 4.0 and again(1, 2) == 3
    assert sum(again.stats.cache_hits.values()) == 2 and len(list(tmp_path.iterdir())) == 2


def test_code_is_read_from_any_folder(file, tmp_path):
    new = tmp_path / "new"
    assert is_loaded(new, file.parent, writes=new) and not new.exists()


@pytest.mark.parametrize("folder", ["/proc/aerodrake", "/dev/null/x"])
def test_a_folder_that_cannot_be_written_costs_only_time(folder):
    assert not is_loaded(Path(folder)) and not is_loaded(Path(folder))


def test_a_full_disk_costs_only_time(tmp_path):
    with room_for(1000):
        assert not is_loaded(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_flush_deletes_the_files_of_the_function(file):
    (file.parent / "other.nbc").touch()
    make(file.parent)._cache.flush()
    assert [path.name for path in file.parent.iterdir()] == ["other.nbc"]
    assert os.path.basename(make(file.parent)._cache.cache_path) == file.parent.name
