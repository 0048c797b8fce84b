"""Files, output and exit codes of `aerodrake identify`."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import aerodrake.identification.identify
from aerodrake.cli import main
from aerodrake.identification.identify import Record
from aerodrake.scenario.load import load_scenario, packaged_scenarios
from aerodrake.support.errors import ProcessDied
from tests.ideal_base import K_B, replace_flights

FILES = ["identification.json", "identification.png", "scenario.yaml"]


@pytest.fixture
def ideal(monkeypatch):
    replace_flights(monkeypatch)


@pytest.fixture
def scenario(tmp_path) -> Path:
    """Copy of a packaged scenario in an empty folder."""
    (tmp_path / "mine").mkdir()
    return Path(shutil.copy(packaged_scenarios()["clover_paper"], tmp_path / "mine" / "own.yaml"))


def files(folder: Path) -> dict[str, bytes]:
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


def test_files_of_an_identification(ideal, tmp_path):
    out = tmp_path / "out"
    options = ["--set", "seed=3", "--set", "name=other", "--quiet", "--out", str(out)]
    assert main(["identify", *options]) == 0
    assert sorted(files(out)) == FILES
    figures = json.loads((out / "identification.json").read_text())
    assert figures["command"] == f"aerodrake identify {out / 'scenario.yaml'}"
    assert figures["k_b"] == list(K_B) and figures["scenario_k_b"] == [2.46, 2.46, 2.47]
    assert figures["scenario"] == "other"
    own = load_scenario("clover_paper", seed=3, name="other")
    again = load_scenario(str(out / "scenario.yaml"))
    assert again.model == replace(own.model, k_b=K_B)
    assert replace(again, model=own.model, source=own.source) == own


def test_default_folder_and_output(ideal, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    assert main(["identify", "hover", "--set", "seed=3"]) == 0
    (out,) = Path("runs").iterdir()
    assert out.name.startswith("identify-hover-") and sorted(files(out)) == FILES
    output, progress = capfd.readouterr()
    assert f"{out}: identification.json, scenario.yaml, identification.png" in output
    assert output.rstrip().splitlines()[-1] == "--set 'model.k_b=[1.5,2,2.5]'"
    assert "360.0/360.0 s" in progress
    assert load_scenario(str(out / "scenario.yaml")).model.k_b == K_B


def test_an_earlier_identification_is_replaced_as_a_whole(ideal, tmp_path):
    out = tmp_path / "out"
    for _ in range(2):
        assert main(["identify", "hover", "--quiet", "--out", str(out)]) == 0
        assert sorted(files(out)) == FILES
        (out / "left_behind.txt").touch()


@pytest.mark.parametrize("names", [["thesis.tex"], ["summary.json", "log.npz", "scenario.yaml"]])
def test_a_folder_with_other_files_is_refused(names, ideal, tmp_path, capsys):
    out = tmp_path / "out"
    out.mkdir()
    for name in names:
        (out / name).write_text("precious")
    assert main(["identify", "hover", "--quiet", "--out", str(out)]) == 2
    assert capsys.readouterr().err.startswith(f"aerodrake: {out}: holds files")
    assert files(out) == dict.fromkeys(names, b"precious")


def test_write_changes_only_k_b_in_the_file(ideal, scenario, tmp_path, capsys):
    before = scenario.read_text()
    argv = ["identify", str(scenario), "--write", "--out", str(tmp_path / "out")]
    assert main(argv) == 0
    assert scenario.read_text() == before.replace("[2.46, 2.46, 2.47]", "[1.5, 2.0, 2.5]") != before
    assert list(scenario.parent.iterdir()) == [scenario]
    assert f"{scenario}: model.k_b replaced" in capsys.readouterr().out
    assert load_scenario(str(scenario)).model.k_b == K_B


def test_without_write_the_file_is_unchanged(ideal, scenario, tmp_path):
    before = files(scenario.parent)
    assert main(["identify", str(scenario), "--quiet", "--out", str(tmp_path / "out")]) == 0
    assert files(scenario.parent) == before


def test_write_to_a_packaged_scenario(ideal, scenario, tmp_path, monkeypatch):
    monkeypatch.setattr("aerodrake.scenario.load.packaged_scenarios", lambda: {"own": scenario})
    argv = ["identify", "own", "--write", "--quiet", "--out", str(tmp_path / "out")]
    assert main(argv) == 0
    assert load_scenario("own").model.k_b == K_B


@pytest.mark.parametrize(
    ("argv", "expected"),
    [
        (["clovr"], "clovr: no such scenario; did you mean 'clover'?"),
        (["own.yaml", "--set", "mpc.horizon=x"], "--set: mpc.horizon: expected a whole number"),
        (
            ["own.yaml", "--set", "vehicle.robot=gone.urdf"],
            "gone.urdf: expected a readable file",
        ),
        (["own.yaml", "--write", "--set", "seed=1"], "--write: expected no --set"),
        (["bare.yaml", "--write"], "bare.yaml: model.k_b: expected this key in the file"),
    ],
)
def test_bad_input_prints_one_line_and_writes_nothing(argv, expected, scenario, monkeypatch, capfd):
    monkeypatch.chdir(scenario.parent)
    Path("bare.yaml").write_text("seed: 1\n")

    def run_parallel(*_):
        raise AssertionError("flown")

    monkeypatch.setattr(aerodrake.identification.identify, "run_parallel", run_parallel)
    before = files(Path())
    assert main(["identify", *argv]) == 2
    err = capfd.readouterr().err.splitlines()
    assert (
        expected in err[-1] and len([line for line in err if line.startswith("aerodrake: ")]) == 1
    )
    assert files(Path()) == before


@pytest.mark.parametrize("jobs", ["0", "-1", "two", "1.5", ""])
def test_jobs_are_whole_numbers_from_one(jobs, capsys):
    with pytest.raises(SystemExit, match="2"):
        main(["identify", "--jobs", jobs])
    assert "expected a whole number in [1, 1000]" in capsys.readouterr().err


def test_a_failed_identification_writes_nothing(ideal, scenario, tmp_path, monkeypatch, capfd):
    out = tmp_path / "out"
    argv = ["identify", str(scenario), "--quiet", "--write", "--out", str(out)]
    assert main(argv) == 0
    before = files(tmp_path)
    rng = np.random.default_rng(0)
    still = Record(*rng.normal(size=(4, 1000)))
    monkeypatch.setattr(aerodrake.identification.identify, "fly", lambda manoeuvre: still)
    assert main(argv) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith(f"aerodrake: {scenario}: flight: expected a base with the response")
    assert files(tmp_path) == before


def test_an_interrupt_writes_nothing(ideal, scenario, tmp_path, monkeypatch, capfd):
    def interrupt(manoeuvre):
        raise KeyboardInterrupt

    monkeypatch.setattr(aerodrake.identification.identify, "fly", interrupt)
    before = files(tmp_path)
    argv = ["identify", str(scenario), "--quiet", "--write", "--out", str(tmp_path / "out")]
    assert main(argv) == 130
    assert capfd.readouterr().err == "aerodrake: interrupted\n"
    assert files(tmp_path) == before


def test_a_dead_process_is_reported_in_one_line(tmp_path, monkeypatch, capsys):
    """Exit code 1: it is neither bad input nor a bug."""
    died = ProcessDied("its process died of SIGKILL")
    monkeypatch.setattr(
        "aerodrake.identification.identify.run_parallel", lambda *_: iter([(1, died)])
    )
    monkeypatch.chdir(tmp_path)
    assert main(["identify", "clover_paper", "--quiet"]) == 1
    assert capsys.readouterr().err == "aerodrake: x, arm moving: its process died of SIGKILL\n"
    assert not [*tmp_path.rglob("*")]
