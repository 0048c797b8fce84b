"""Scratch folders are removed with their process, even if it is killed."""

import os
import subprocess
import sys

import pytest

from aerodrake.support.scratch import NEW, OLD, PREFIX, replace_folder, scratch_folder


def names(folder) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def abandoned(parent, name="dead"):
    """Makes a scratch folder whose process has ended."""
    folder = parent / f"{PREFIX}{name}"
    folder.mkdir()
    return folder


@pytest.mark.parametrize("error", [None, ValueError, KeyboardInterrupt])
def test_the_folder_is_removed_at_the_end(error, tmp_path):
    try:
        with scratch_folder(tmp_path) as folder:
            assert folder.parent == tmp_path and folder.name.startswith(PREFIX)
            (folder / "deep").mkdir()
            (folder / "deep" / "file").touch()
            if error:
                raise error
    except (ValueError, KeyboardInterrupt) as caught:
        assert isinstance(caught, error)
    assert names(tmp_path) == []


def test_only_folders_of_ended_processes_are_removed(tmp_path):
    (abandoned(tmp_path) / "file").touch()
    (tmp_path / ".mine").mkdir()
    with scratch_folder(tmp_path) as first, scratch_folder(tmp_path) as second:
        assert first != second and first.exists()
        assert names(tmp_path) == sorted([".mine", first.name, second.name])
    assert names(tmp_path) == [".mine"]


def test_the_folder_of_a_killed_process_is_removed(tmp_path):
    code = (
        "import os, sys; from pathlib import Path\n"
        "from aerodrake.support.scratch import scratch_folder\n"
        "with scratch_folder(Path(sys.argv[1])) as folder: os.kill(os.getpid(), 9)"
    )
    assert subprocess.run([sys.executable, "-c", code, str(tmp_path)]).returncode == -9
    assert len(names(tmp_path)) == 1
    with scratch_folder(tmp_path) as folder:
        assert names(tmp_path) == [folder.name]


def test_links_are_not_followed(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "file").touch()
    (tmp_path / f"{PREFIX}link").symlink_to("mine")
    (abandoned(tmp_path) / "link").symlink_to(tmp_path / "mine")
    with scratch_folder(tmp_path):
        pass
    assert names(tmp_path / "mine") == ["file"]


@pytest.mark.parametrize("is_new", [True, False])
def test_an_unfinished_replacement_is_completed(is_new, tmp_path):
    """After a kill between the renames; without the new folder the old one is restored."""
    folder = abandoned(tmp_path)
    for parent, text in ((OLD, "old"), (NEW, "new"))[: 1 + is_new]:
        (folder / parent / "run").mkdir(parents=True)
        (folder / parent / "run" / "file").write_text(text)
    with scratch_folder(tmp_path):
        pass
    assert names(tmp_path) == ["run"]
    assert (tmp_path / "run" / "file").read_text() == ("new" if is_new else "old")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_an_error_between_the_renames_loses_neither_folder(error, tmp_path, monkeypatch):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "old").touch()
    rename, calls = os.replace, []

    def replace(source, target):
        calls.append(source)
        if len(calls) == 2:
            raise error
        rename(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(error), scratch_folder(tmp_path) as folder:
        (folder / NEW / "run").mkdir(parents=True)
        (folder / NEW / "run" / "new").touch()
        replace_folder(folder, tmp_path / "run")
    assert names(tmp_path) == ["run"]
    assert names(tmp_path / "run") == (["old"] if error is OSError else ["new"])
