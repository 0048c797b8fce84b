"""Scratch folders: gone with whoever made them, one way or another."""

import os
import subprocess
import sys

import pytest

from aerodrake.support.scratch import NEW, OLD, PREFIX, replace_folder, scratch_folder


def names(folder) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def left(parent, name="dead"):
    """A scratch folder whose process is no more."""
    folder = parent / f"{PREFIX}{name}"
    folder.mkdir()
    return folder


@pytest.mark.parametrize("error", [None, ValueError, KeyboardInterrupt])
def test_it_goes_in_the_end_with_all_that_is_in_it(error, tmp_path):
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


def test_those_of_the_dead_go_and_those_of_the_living_stay(tmp_path):
    (left(tmp_path) / "file").touch()
    (tmp_path / ".mine").mkdir()
    with scratch_folder(tmp_path) as first, scratch_folder(tmp_path) as second:
        assert first != second and first.exists()
        assert names(tmp_path) == sorted([".mine", first.name, second.name])
    assert names(tmp_path) == [".mine"]


def test_that_of_a_process_that_was_killed_goes(tmp_path):
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
    (left(tmp_path) / "link").symlink_to(tmp_path / "mine")
    with scratch_folder(tmp_path):
        pass
    assert names(tmp_path / "mine") == ["file"]


@pytest.mark.parametrize("is_new", [True, False])
def test_a_replacement_that_was_cut_short_is_ended(is_new, tmp_path):
    """Between its two renames; or, if the new one is no more, undone."""
    folder = left(tmp_path)
    for place, text in ((OLD, "old"), (NEW, "new"))[: 1 + is_new]:
        (folder / place / "run").mkdir(parents=True)
        (folder / place / "run" / "file").write_text(text)
    with scratch_folder(tmp_path):
        pass
    assert names(tmp_path) == ["run"]
    assert (tmp_path / "run" / "file").read_text() == ("new" if is_new else "old")


@pytest.mark.parametrize("error", [KeyboardInterrupt, OSError])
def test_neither_is_lost_between_the_renames(error, tmp_path, monkeypatch):
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
