"""The folder of a run: complete, or not there."""

import os
from pathlib import Path

import pytest

from aerodrake.support.errors import BadInput
from aerodrake.support.run_folder import run_folder

NAMES = ("summary.json", "log.npz", "scenario.yaml")


def write(target: Path, text: str = "new", names=NAMES) -> None:
    with run_folder(target) as folder:
        for name in names:
            (folder / name).write_text(text)


def texts(folder: Path) -> dict[str, str]:
    """All files below a folder, hidden ones too; empty folders as their name and a slash."""
    found = {}
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            found[str(path.relative_to(folder))] = path.read_text()
        elif not any(path.iterdir()):
            found[f"{path.relative_to(folder)}/"] = ""
    return found


def run(text: str, prefix: str = "run") -> dict[str, str]:
    return {f"{prefix}/{name}": text for name in NAMES}


def test_is_not_there_until_it_is_complete(tmp_path):
    with run_folder(tmp_path / "run") as folder:
        (folder / "summary.json").write_text("new")
        assert not (tmp_path / "run").exists()
        assert folder.parents[1].parent == tmp_path  # On the same disk: a rename is all it takes.
    assert texts(tmp_path) == {"run/summary.json": "new"}


def test_parents_are_made(tmp_path):
    write(tmp_path / "a" / "b" / "run")
    assert texts(tmp_path) == run("new", "a/b/run")


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
def test_failure_leaves_everything_as_it_was(error, tmp_path):
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
def test_a_full_disk_is_said_to_be_one(error, reason, tmp_path):
    with (
        pytest.raises(BadInput, match=f"^--out: cannot write .*run: {reason}$"),
        run_folder(tmp_path / "run"),
    ):
        raise error
    assert texts(tmp_path) == {}


@pytest.mark.parametrize("failing", [1, 2])
def test_an_earlier_run_survives_a_disk_that_fails(failing, tmp_path, monkeypatch):
    """At whichever of the two renames."""
    write(tmp_path / "run", "old")
    calls, rename = [], os.replace

    def replace(source, target):
        calls.append(target)
        if len(calls) == failing:
            raise OSError(5, "Input/output error")
        rename(source, target)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(BadInput, match="^--out: cannot write .*: Input/output error$"):
        write(tmp_path / "run")
    assert texts(tmp_path) == run("old")


@pytest.mark.parametrize(
    "own",
    [["thesis.tex"], [".hidden"], ["summary.json"], ["summary.json", "scenario.yaml"], ["a/b"]],
)
def test_a_folder_of_another_kind_is_refused(own, tmp_path):
    for name in own:
        path = tmp_path / "mine" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("precious")
    before = texts(tmp_path)
    with pytest.raises(BadInput, match="--out: .*mine holds files that are not of an earlier run"):
        write(tmp_path / "mine")
    assert texts(tmp_path) == before


@pytest.mark.parametrize("where", [".", "..", "../..", "../../b"])
def test_the_working_directory_is_not_pulled_from_under_you(where, tmp_path, monkeypatch):
    """And this is said before the flight, not after it."""
    (tmp_path / "b" / "c").mkdir(parents=True)
    monkeypatch.chdir(tmp_path / "b" / "c")
    entered = False
    with pytest.raises(BadInput, match="^--out: "), run_folder(Path(where)):
        entered = True
    assert not entered
    assert Path.cwd() == tmp_path / "b" / "c"
    assert texts(tmp_path) == {"b/c/": ""}


def test_a_link_to_a_run_goes_on_leading_to_it(tmp_path):
    write(tmp_path / "run", "old")
    (tmp_path / "latest").symlink_to("run")
    write(tmp_path / "latest")
    assert (tmp_path / "latest").is_symlink()
    assert texts(tmp_path / "run") == dict.fromkeys(NAMES, "new")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["latest", "run"]


def test_a_link_that_leads_nowhere_is_refused_before_the_flight(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    entered = False
    with pytest.raises(BadInput, match="--out: .*a is a link"), run_folder(tmp_path / "a"):
        entered = True
    assert not entered and (tmp_path / "a").is_symlink()


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").write_text("precious")
    for target in ("file", "file/run"):
        with pytest.raises(BadInput, match="^--out: .*file"):
            write(tmp_path / target)
    assert texts(tmp_path) == {"file": "precious"}


@pytest.mark.parametrize("target", ["/proc/run", "x" * 300, "a\0b", "/dev/null/run"])
def test_what_cannot_be_written_is_named(target, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BadInput, match="^--out: cannot write |^--out: .*a file$") as caught:
        write(Path(target))
    assert "None" not in str(caught.value) and "Errno" not in str(caught.value)
    assert texts(tmp_path) == {}


@pytest.mark.parametrize("name", ["-rf", "ü & x", "with space", ".hidden", "x" * 250])
def test_any_name_will_do(name, tmp_path):
    write(tmp_path / name)
    assert texts(tmp_path / name) == dict.fromkeys(NAMES, "new")


@pytest.mark.parametrize("umask", [0o022, 0o077, 0o002])
def test_who_may_read_it_is_up_to_the_umask(umask, tmp_path):
    before = os.umask(umask)
    try:
        write(tmp_path / "run")
        assert os.umask(umask) == umask
    finally:
        os.umask(before)
    assert (tmp_path / "run").stat().st_mode & 0o777 == 0o777 & ~umask
    assert (tmp_path / "run" / NAMES[0]).stat().st_mode & 0o777 == 0o666 & ~umask


def test_each_kind_of_run_replaces_its_own_kind_only(tmp_path):
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
