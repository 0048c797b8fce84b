"""The scripts in diagrams/: one screen each, and they do what they are there for."""

import ast
import os
import runpy
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aerodrake.scenario import FigureEight

DIAGRAMS = Path(__file__).parents[1] / "diagrams"
SCRIPTS = sorted(DIAGRAMS.glob("*.py"))


def name(path: Path) -> str:
    return path.stem


def test_there_are_scripts():
    assert len(SCRIPTS) >= 4


LONG = ("fly_clover", "fly_over_lcm", "search_weights")
"""Tested by themselves below."""


@pytest.mark.parametrize("script", [s for s in SCRIPTS if s.stem not in LONG], ids=name)
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


def test_the_search_of_weights_finds_the_cheapest(scenario):
    """Of a cost that is known: a bowl about weights half a decade from the start."""
    script = runpy.run_path(str(DIAGRAMS / "search_weights.py"))
    target = np.array([0.5, -0.5, 0.3, 0.0, -0.2])
    search = script["search"]
    search.__globals__["cost"] = lambda scenarios, start, decades: np.sum((decades - target) ** 2)
    cost, best = search(([scenario], script["START"], 200))
    assert cost < 1e-3
    found = [getattr(best.mpc, w)[0] / start for w, start in script["START"].items()]
    np.testing.assert_allclose(np.log10(found), target, atol=0.05)
    assert best.mpc.w_1 == scenario.mpc.w_1


def test_the_search_of_weights_charges_a_metre_for_a_lap_not_flown(scenario):
    script = runpy.run_path(str(DIAGRAMS / "search_weights.py"))
    cost = script["cost"]
    cost.__globals__["PATHS"] = ((FigureEight(), 0.1),)
    assert cost([replace(scenario, settle_s=0.0)], script["START"], np.zeros(5)) == 1.0


def test_two_processes_fly(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    main = runpy.run_path(str(DIAGRAMS / "fly_over_lcm.py"), run_name="imported")["main"]
    patient = ("--set", "supervisor.plan_ticks=1000", "--set", "supervisor.plan_lost_s=1000")
    patient += ("--set", "supervisor.attitude_lost_s=60")
    url = f"udpm://239.255.76.67:{20_000 + os.getpid() % 10_000}?ttl=0"
    main("hover", "--lcm", url, "--set", "duration=0.5", "--set", "settle_s=0.1", *patient)
    said = capfd.readouterr().out
    assert "completed" in said and "tracking.png" in said
