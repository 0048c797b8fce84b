"""Exit codes and bad input of `aerodrake sweep`."""

import json

import pytest

from aerodrake.cli import main
from aerodrake.sweeps import loop as module
from aerodrake.sweeps.folder import read_rows
from aerodrake.sweeps.plan import Plan
from aerodrake.sweeps.study_files import ROWS
from tests.in_this_process import call_in_this_process


@pytest.fixture
def _here(monkeypatch):
    """Flies trials in this process instead of child processes."""
    monkeypatch.setattr(module, "call_in_child", call_in_this_process)


@pytest.mark.usefixtures("_here")
def test_refused_trials_are_rows_and_exit_code_1(tmp_path, capsys):
    """Some trials draw a negative payload."""
    options = ["hover", "--trials", "8", "--vary", "payload.mass_kg=normal(0, 0.1)"]
    short = ["--set", "settle_s=0", "--set", "duration=0.04", "--jobs", "1"]
    assert main(["sweep", *options, *short, "--out", str(tmp_path / "sweep")]) == 1
    endings = [row["exit_reason"] for row in read_rows(tmp_path / "sweep")]
    output = capsys.readouterr().out
    assert 0 < endings.count("refused") < 8
    assert f"{endings.count('refused')} refused" in output


@pytest.mark.usefixtures("_here")
def test_lost_flights_are_a_success(tmp_path):
    weak = ["vehicle.rotor.max_thrust_n=2", "vehicle.base_position_m=[0, 0, 9]", "duration=1"]
    options = [word for change in weak for word in ("--set", change)]
    out = tmp_path / "sweep"
    options += ["--trials", "1", "--jobs", "1", "--quiet", "--out", str(out)]
    assert main(["sweep", "hover", *options]) == 0
    assert [row["exit_reason"] for row in read_rows(out)] == ["lost"]
    assert json.loads((out / Plan.files.summary).read_text())["error"] is None


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["clovr", "--trials", "1"], "did you mean 'clover'?"),
        (["hover"], "--trials: expected a number of trials, since no linspace() spans a grid"),
        (["hover", "--trials", "2", "--vary", "duraton=uniform(1,2)"], "--vary: duraton: unknown"),
        (["hover", "--vary", "duration"], "--vary: expected dotted.key=distribution, got 'durat"),
        (["hover", "--vary", "=uniform(1,2)"], "--vary: expected dotted.key=distribution"),
        (
            ["hover", *["--vary", "duration=linspace(1,2,2)"] * 2],
            "duration: expected each key once",
        ),
        (["hover", "--trials", "2", "--vary", "duration=gamma(1)"], "no such distribution 'gamma'"),
        (
            ["hover", "--trials", "2", "--resume"],
            "--resume: expected --out DIR with the",
        ),
        (["hover", "--trials", "2", "--resume", "--out", "no"], "the folder of a sweep, got no"),
        (["hover", "--trials", "2", "--out", "file"], "file: cannot be written: "),
        (["hover", "--trials", "2", "--out", "mine"], "mine: holds files that are not of an ear"),
        (["hover", "--trials", "2", "--seed", "x"], "seed: expected a whole number"),
        (["hover", "--trials", "2", "--set", "vehicle.robot=no.urdf"], "no.urdf: "),
        (
            ["hover", "--trials", "2", "--vary", "allocation.d_edge_m=choice(0.01)"],
            "--vary: allocation.d_edge_m: trial 0: expected more than d_h_m",
        ),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(
    options, expected, tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("aerodrake.api.study.fly_trials", lambda *_: pytest.fail("flown"))
    (tmp_path / "file").write_text("precious")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / ROWS).write_text("precious")
    assert main(["sweep", *options, "--quiet"]) == 2
    out, error = capsys.readouterr()
    assert out == "" and expected in error and len(error.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["file", "mine", ROWS]


@pytest.mark.parametrize("options", [["--trials", "0"], ["--jobs", "0"], ["--trials", "100001"]])
def test_counts_are_whole_numbers_from_one(options, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["sweep", "hover", *options])
    assert f"argument {options[0]}: expected a whole number in [1, " in capsys.readouterr().err
