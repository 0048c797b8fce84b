"""The folder of a run is written atomically."""

import os
from pathlib import Path

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.support.run_folder import check_target, run_folder

NAMES = ("summary.json", "log.npz", "scenario.yaml")


def write(target: Path, text: str = "new", names=NAMES) -> None:
    with run_folder(target) as folder:
        for name in names:
            (folder / name).write_text(text)


def texts(folder: Path) -> dict[str, str]:
    """Returns all files in a folder, hidden ones too; empty folders as their name and a slash."""
    contents = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            contents[str(path.relative_to(folder))] = path.read_text()
        elif not any(path.iterdir()):
            contents[f"{path.relative_to(folder)}/"] = ""
    return contents


def run(text: str, prefix: str = "run") -> dict[str, str]:
    return {f"{prefix}/{name}": text for name in NAMES}


def test_the_folder_appears_when_it_is_complete(tmp_path):
    with run_folder(tmp_path / "run") as folder:
        (folder / "summary.json").write_text("new")
        assert not (tmp_path / "run").exists()
        assert folder.parents[1].parent == tmp_path  # On the same file system.
    assert texts(tmp_path) == {"run/summary.json": "new"}


def test_parents_are_created(tmp_path):
    write(tmp_path / "a" / "b" / "run")
    assert texts(tmp_path) == run("new", "a/b/run")


def test_a_check_of_the_target_creates_nothing(tmp_path):
    (tmp_path / "link").symlink_to("a")
    assert check_target(tmp_path / "link" / "b") == tmp_path / "a" / "b"
    assert [path.name for path in tmp_path.iterdir()] == ["link"]


def test_an_empty_folder_is_filled(tmp_path):
    (tmp_path / "run").mkdir()
    write(tmp_path / "run")
    assert texts(tmp_path) == run("new")


def test_an_earlier_run_is_replaced_as_a_whole(tmp_path):
    write(tmp_path / "run", "old", [*NAMES, "extra.txt"])
    (tmp_path / "run" / "deeper").mkdir()
    with run_folder(tmp_path / "run") as folder:
        for name in NAMES:
            (folder / name).write_text("new")
        assert (tmp_path / "run" / "extra.txt").read_text() == "old"
    assert texts(tmp_path) == run("new")


@pytest.mark.parametrize("error", [RuntimeError, ValueError, KeyboardInterrupt, SystemExit])
def test_an_error_leaves_everything_unchanged(error, tmp_path):
    write(tmp_path / "run", "old")
    with pytest.raises(error), run_folder(tmp_path / "run") as folder:
        (folder / "summary.json").write_text("new")
        raise error("inside")
    assert texts(tmp_path) == run("old")
    with pytest.raises(error), run_folder(tmp_path / "other"):
        raise error("inside")
    assert texts(tmp_path) == run("old")


@pytest.mark.parametrize(
    ("error", "reason"),
    [(OSError(28, "No space left on device"), "No space left on device"), (OSError("no"), "no")],
)
def test_a_full_disk_is_reported(error, reason, tmp_path):
    with (
        pytest.raises(BadInput, match=f"run: cannot be written: {reason}$"),
        run_folder(tmp_path / "run"),
    ):
        raise error
    assert texts(tmp_path) == {}


@pytest.mark.parametrize("failing", [1, 2])
def test_an_earlier_run_survives_a_failing_disk(failing, tmp_path, monkeypatch):
    """Either of the two renames fails."""
    write(tmp_path / "run", "old")
    calls, rename = [], os.replace

    def replace(source, target):
        calls.append(target)
        if len(calls) == failing:
            raise OSError(5, "Input/output error")
        rename(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(BadInput, match=": cannot be written: Input/output error$"):
        write(tmp_path / "run")
    assert texts(tmp_path) == run("old")


@pytest.mark.parametrize(
    "own",
    [["thesis.tex"], [".hidden"], ["summary.json"], ["summary.json", "scenario.yaml"], ["a/b"]],
)
def test_a_folder_with_other_files_is_refused(own, tmp_path):
    for name in own:
        path = tmp_path / "mine" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("precious")
    before = texts(tmp_path)
    with pytest.raises(BadInput, match="mine: holds files that are not of"):
        write(tmp_path / "mine")
    assert texts(tmp_path) == before


@pytest.mark.parametrize("where", [".", "..", "../..", "../../b"])
def test_the_working_directory_is_not_replaced(where, tmp_path, monkeypatch):
    """The error is raised before the flight."""
    (tmp_path / "b" / "c").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "b" / "c")
    entered = False
    with pytest.raises(BadInput, match=r"^[./b]+: "), run_folder(Path(where)):
        entered = True
    assert not entered
    assert Path.cwd() == tmp_path / "b" / "c"
    assert texts(tmp_path) == {"b/c/": ""}


def test_a_link_to_a_run_is_preserved(tmp_path):
    write(tmp_path / "run", "old")
    (tmp_path / "latest").symlink_to("run")
    write(tmp_path / "latest")
    assert (tmp_path / "latest").is_symlink()
    assert texts(tmp_path / "run") == dict.fromkeys(NAMES, "new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["latest", "run"]


def test_a_link_to_itself_is_refused_before_the_flight(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    entered = False
    with pytest.raises(BadInput, match="a: expected .* got a link"), run_folder(tmp_path / "a"):
        entered = True
    assert not entered and (tmp_path / "a").is_symlink()


def test_a_file_is_refused(tmp_path):
    (tmp_path / "file").write_text("precious")
    for target in ("file", "file/run"):
        with pytest.raises(BadInput, match=r"file(/run)?: "):
            write(tmp_path / target)
    assert texts(tmp_path) == {"file": "precious"}


@pytest.mark.parametrize("target", ["/proc/run", "x" * 300, "a\0b", "/dev/null/run"])
def test_an_unwritable_path_is_named(target, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match=": cannot be |got a file$|without a NUL$") as caught:
        write(Path(target))
    assert "None" not in str(caught.value) and "Errno" not in str(caught.value)
    assert texts(tmp_path) == {}


@pytest.mark.parametrize("name", ["-rf", "ü & x", "with space", ".hidden", "x" * 250])
def test_any_folder_name_is_accepted(name, tmp_path):
    write(tmp_path / name)
    assert texts(tmp_path / name) == dict.fromkeys(NAMES, "new")


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_modes_follow_the_umask(umask, tmp_path):
    before = os.umask(umask)
    try:
        write(tmp_path / "run")
        assert os.umask(umask) == umask
    finally:
        os.umask(before)
    assert (tmp_path / "run").stat().st_mode & 0o777 == 0o777 & ~umask
    assert (tmp_path / "run" / NAMES[0]).stat().st_mode & 0o777 == 0o666 & ~umask


def test_results_replace_only_results_of_the_same_command(tmp_path):
    write(tmp_path / "run", "old")
    with (
        pytest.raises(BadInput, match="not of an earlier run"),
        run_folder(tmp_path / "run", ["comparison.json"]),
    ):
        pass
    assert texts(tmp_path) == run("old")
    for text in ("first", "second"):
        with run_folder(tmp_path / "other", ["comparison.json"]) as folder:
            (folder / "comparison.json").write_text(text)
    assert texts(tmp_path / "other") == {"comparison.json": "second"}
