"""Folders for files that can be made again, for any user."""

import os
from pathlib import Path

import pytest

from aerodrake.support import cache_folders
from aerodrake.support.cache_folders import (
    is_writable,
    let_matplotlib_cache,
    private_folder,
    user_folder,
)


@pytest.fixture
def temporary(tmp_path, monkeypatch) -> Path:
    """This user's folder below a folder of temporary files, not created yet."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    return tmp_path / f"aerodrake-{os.getuid()}"


@pytest.mark.parametrize(
    ("variable", "home", "expected"),
    [
        ("/xdg", "/home/a/.cache", "/xdg"),
        ("", "/home/a/.cache", "/home/a/.cache"),
        ("relative", "/home/a/.cache", "/home/a/.cache"),
        ("", "~/.cache", None),  # An unknown user without HOME.
        ("/xdg", "~/.cache", "/xdg"),
    ],
)
def test_the_users_folder(variable, home, expected, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", variable)
    monkeypatch.setattr(os.path, "expanduser", lambda path: home)
    folder = user_folder("XDG_CACHE_HOME", "~/.cache")
    assert folder == (expected and Path(expected))


@pytest.mark.parametrize("folder", ["/proc/x", "/dev/null", "/dev/null/x", "a\0b", "x" * 300])
def test_folders_that_cannot_be_written(folder, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert not is_writable(Path(folder)) and list(tmp_path.iterdir()) == []


def test_the_temporary_folder_is_found_again_and_is_private(temporary):
    assert private_folder() == temporary == private_folder()
    assert temporary.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize(
    "take",
    [
        lambda folder: folder.touch(),
        lambda folder: folder.symlink_to(folder.parent),
        lambda folder: (folder.mkdir(), folder.chmod(0o777)),
        lambda folder: (folder.mkdir(), os.chown(folder, 54321, 54321)),
    ],
    ids=["file", "link", "writable by all", "of another user"],
)
def test_the_temporary_folder_is_not_shared_with_others(take, temporary):
    """Whoever can write to it could make this user's processes run other code."""
    try:
        take(temporary)
    except PermissionError:
        pytest.skip("only root can give a folder away")
    assert private_folder() is None


def test_without_a_folder_of_temporary_files(monkeypatch):
    def gettempdir():
        raise FileNotFoundError(2, "No usable temporary directory found")

    monkeypatch.setattr("tempfile.gettempdir", gettempdir)
    assert private_folder() is None


def test_matplotlib_has_a_folder_that_can_be_written(temporary, tmp_path, monkeypatch):
    for variable in ("MPLCONFIGDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    let_matplotlib_cache()
    monkeypatch.delenv("MPLCONFIGDIR")
    let_matplotlib_cache()
    assert "MPLCONFIGDIR" not in os.environ and not temporary.exists()
    monkeypatch.setenv("XDG_CONFIG_HOME", "/proc/config")
    let_matplotlib_cache()
    assert os.environ["MPLCONFIGDIR"] == str(temporary / "matplotlib")
    monkeypatch.setenv("MPLCONFIGDIR", "/proc/matplotlib")
    let_matplotlib_cache()
    assert os.environ["MPLCONFIGDIR"] == str(temporary / "matplotlib")
    monkeypatch.setenv("MPLCONFIGDIR", "/proc/matplotlib")
    monkeypatch.setattr(cache_folders, "private_folder", lambda: None)
    let_matplotlib_cache()  # matplotlib itself reports it.
    assert os.environ["MPLCONFIGDIR"] == "/proc/matplotlib"
