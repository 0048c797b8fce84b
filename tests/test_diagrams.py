"""The scripts in diagrams/: one screen each, and they do what they are there for."""

import ast
import os
import runpy
import shutil
from pathlib import Path

import pytest

DIAGRAMS = Path(__file__).parents[1] / "diagrams"
SCRIPTS = sorted(DIAGRAMS.glob("*.py"))


def name(path: Path) -> str:
    return path.stem


def test_there_are_scripts():
    assert len(SCRIPTS) >= 4


@pytest.mark.parametrize("script", [s for s in SCRIPTS if s.stem != "fly_clover"], ids=name)
def test_runs_and_prints(script, tmp_path, monkeypatch, capsys):
    """As a copy, in a folder of its own: what it writes goes there."""
    copy = Path(shutil.copy(script, tmp_path))
    monkeypatch.chdir(tmp_path)
    runpy.run_path(str(copy), run_name="__main__")
    assert capsys.readouterr().out.strip()


@pytest.mark.parametrize("script", SCRIPTS, ids=name)
def test_fits_on_a_screen(script):
    text = script.read_text()
    assert len(text.splitlines()) <= 70
    assert all(len(line) <= 100 for line in text.splitlines())
    tree = ast.parse(text)
    assert ast.get_docstring(tree)
    assert "pydrake.all" not in text
    assert not os.access(script, os.X_OK)  # They are run with python, as the README has it.


@pytest.mark.parametrize("script", SCRIPTS, ids=name)
def test_does_nothing_when_it_is_imported(script, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    copy = Path(shutil.copy(script, tmp_path))
    assert callable(runpy.run_path(str(copy), run_name="imported")["main"])
    assert capsys.readouterr().out == ""
    assert [path.name for path in tmp_path.iterdir() if path.is_file()] == [script.name]


def test_the_flight_of_the_clover_stays_on_it(capsys):
    runpy.run_path(str(DIAGRAMS / "fly_clover.py"), run_name="__main__")
    lines = capsys.readouterr().out.splitlines()
    errors = [float(line.split("error ")[1].removesuffix(" mm")) for line in lines]
    assert len(errors) == 11 and max(errors) < 12
