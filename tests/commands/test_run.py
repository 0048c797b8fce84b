"""Files, folders and exit codes of `aerodrake run`."""

import json
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest
import yaml

import aerodrake
from aerodrake.cli import main
from aerodrake.flight.summary import repeatable

FILES = [
    *("log.npz", "replay.html", "report.html", "scenario.yaml", "summary.json", "tracking.png")
]

TINY = ["--duration", "0.1", "--set", "settle_s=0", "--quiet"]

NOISY = """
duration: 0.2
settle_s: 0.1
reference: {kind: waypoints, file: path.csv}
sensors: {position_noise_m: 1.0e-3, velocity_noise_m_s: 1.0e-2, joint_noise_rad: 1.0e-4}
residual: {mode: online, learning_rate: 0.01, batch: 5, gate_s: 0}
"""


def log(folder: Path) -> dict[str, np.ndarray]:
    with np.load(folder / "log.npz", allow_pickle=False) as arrays:
        return dict(arrays)


def summary(folder: Path) -> dict:
    return json.loads((folder / "summary.json").read_text())


def files(folder: Path) -> dict[str, bytes]:
    """Returns the content of all files in a folder, hidden ones too."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def noisy(tmp_path_factory) -> Path:
    """Folder of a run with noise, online learning and a file that the scenario names."""
    folder = tmp_path_factory.mktemp("noisy")
    (folder / "flight.yaml").write_text(NOISY)
    (folder / "path.csv").write_text("t,x,y,z\n0,0,0.2,1.2\n1,0.1,0.2,1.2\n")
    out = folder / "deep" / "run"
    assert main(["run", str(folder / "flight.yaml"), "--quiet", "--out", str(out)]) == 0
    for name in ("flight.yaml", "path.csv"):
        (folder / name).unlink()
    return out


# Files.


def test_run_writes_exactly_its_files(noisy):
    assert set(FILES) < set(files(noisy)) and len(files(noisy)) == len(FILES) + 1  # And the CSV.
    assert [p.name for p in noisy.parent.iterdir()] == ["run"]
    assert (noisy / "tracking.png").read_bytes().startswith(b"\x89PNG\r\n\x1a\n")


def test_summary_has_every_key(noisy):
    figures = summary(noisy)
    assert figures["scenario"] == "flight" and figures["seed"] == 0
    assert figures["version"] == version("aerodrake")
    assert figures["exit_reason"] == "completed" and figures["exit_cause"] == ""
    assert figures["simulated_s"] == pytest.approx(0.3)
    assert figures["real_time_factor"] == pytest.approx(0.3 / figures["wall_s"])
    for error in (figures["error"], figures["base_error"]):
        assert set(error) == {
            "mean_m", "rms_m", "max_m", "lap_mean_m", "settled_mean_m", "approach_s"
        }  # fmt: skip
        assert 0 < error["mean_m"] <= error["rms_m"] <= error["max_m"] < 0.05
        assert error["lap_mean_m"] is error["settled_mean_m"] is None
        assert error["approach_s"] == 0
    assert figures["mpc"]["ticks"] == 15  # 0.3 s, each 20 ms.
    assert 0 < figures["mpc"]["median_ms"] <= figures["mpc"]["p99_ms"]
    assert figures["mpc"]["solver_fallbacks"] == figures["mpc"]["missed"] == 0
    assert isinstance(figures["mpc"]["overruns"], int)
    assert set(figures["modes"]) == {"flight", "coordinated", "hover", "adjustment"}
    assert sum(figures["modes"].values()) == pytest.approx(0.2)
    with_network, without = figures["residual"]["prediction_rmse_m_s"].values()
    assert with_network > 0 and without > 0 and with_network != without


def test_log_loads_without_pickle(noisy):
    arrays = log(noisy)
    for key, array in arrays.items():
        assert array.dtype.kind in "fiuU", key
    assert len(arrays["time_s"]) == 31 and len(arrays["tick_ms"]) == 15
    for key in set(arrays) - {"tick_ms"}:
        assert len(arrays[key]) == 31, key


def test_replay_has_the_paths_of_reference_and_end_effector(noisy):
    page = (noisy / "replay.html").read_text()
    assert page.lstrip().lower().startswith("<!doctype html>")
    for name in ("/paths/reference", "/paths/end_effector"):
        assert page.count(name) or encoded_in(page, name), name


def encoded_in(page: str, name: str) -> bool:
    """Returns True if one of the page's base64 messages contains the name."""
    import base64
    import re

    return any(
        name.encode() in base64.b64decode(message)
        for message in re.findall(r'base64,([A-Za-z0-9+/=]+)"', page)
    )


def test_the_saved_scenario_gives_the_same_flight(noisy, tmp_path, monkeypatch):
    """It runs in another folder, after the original files are removed."""
    text = yaml.safe_load((noisy / "scenario.yaml").read_text())
    assert text["mpc"]["horizon"] == 15 and text["vehicle"]["rotor"]["lag_up_s"] == 0.0125
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(noisy / "scenario.yaml"), "--quiet", "--out", "again"]) == 0
    ours, again = log(noisy), log(tmp_path / "again")
    assert list(ours) == list(again)
    for key in set(ours) - {"tick_ms"}:
        np.testing.assert_array_equal(ours[key], again[key], err_msg=key)

    assert repeatable(summary(noisy)) == repeatable(summary(tmp_path / "again"))
    ours, again = files(noisy), files(tmp_path / "again")
    assert set(ours) == set(again)
    for name in set(ours) - {"summary.json", "log.npz", "report.html"}:  # These have wall times.
        assert ours[name] == again[name], name


@pytest.mark.usefixtures("undrawn")
def test_files_given_relative_to_the_working_directory_are_saved(tmp_path, monkeypatch):
    """One of them is called as a file of the results."""
    monkeypatch.chdir(tmp_path)
    robot = Path(aerodrake.__file__).parent / "robots" / "quadrotor_arm6.urdf"
    Path("mine.urdf").write_text(robot.read_text())
    Path("summary.json").write_text("t,x,y,z\n0,0,0.2,1.2\n1,0.1,0.2,1.2\n")
    typed = ["--set", "vehicle.robot=mine.urdf", "--set", "reference.file=summary.json"]
    assert main(["run", "waypoints", *TINY, *typed, "--out", "deep/run"]) == 0
    assert summary(Path("deep/run"))["exit_reason"] == "completed"
    assert main(["run", "deep/run/scenario.yaml", "--quiet", "--out", "again"]) == 0


@pytest.mark.usefixtures("undrawn")
def test_options_change_the_scenario_and_are_recorded(tmp_path):
    out = tmp_path / "run"
    options = ["--seed", "7", "--duration", "0.04", "--set", "settle_s=0.02"]
    assert main(["run", "hover", *options, "--set", "seed=3", "--quiet", "--out", str(out)]) == 0
    figures, scenario = summary(out), yaml.safe_load((out / "scenario.yaml").read_text())
    assert figures["seed"] == scenario["seed"] == 7
    assert figures["simulated_s"] == pytest.approx(0.06)
    assert (scenario["duration"], scenario["settle_s"]) == (0.04, 0.02)


@pytest.mark.usefixtures("undrawn")
def test_default_folder_and_output(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    wide = ["--set", "allocation.d_h_m=0.08"]
    assert main(["run", "hover", "--duration", "0.1", "--set", "settle_s=0", *wide]) == 0
    (run,) = Path("runs").iterdir()
    assert run.name.startswith("hover-") and sorted(p.name for p in run.iterdir()) == FILES
    output, progress = capfd.readouterr()
    assert "note: allocation.d_h_m (0.08 m)" in output
    assert "hover: completed" in output and "end-effector error" in output
    assert output.rstrip().splitlines()[-1].startswith(f"{run}: ")
    assert "0.1/0.1 s" in progress


@pytest.mark.usefixtures("undrawn")
def test_the_folder_is_checked_before_the_flight_is_built(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        "aerodrake.flight.simulate.FlightSimulation", lambda *_, **__: pytest.fail()
    )
    (tmp_path / "file").touch()
    assert main(["run", "hover", "--out", str(tmp_path / "file")]) == 2
    out, err = capsys.readouterr()
    assert out == "" and ": expected a folder, got a file" in err


def test_two_runs_in_one_second_have_two_folders(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("time.strftime", lambda format: "now")
    for _ in range(2):
        assert main(["run", "hover", *TINY]) == 0
    assert len(list(Path("runs").iterdir())) == 2


# Folders.


@pytest.mark.usefixtures("undrawn")
def test_an_earlier_run_is_replaced_as_a_whole(tmp_path):
    out = tmp_path / "run"
    for seed in ("1", "2"):
        assert main(["run", "hover", *TINY, "--seed", seed, "--out", str(out)]) == 0
        assert summary(out)["seed"] == int(seed)
        assert not (out / "left_behind.txt").exists()
        (out / "left_behind.txt").touch()
    (out / "left_behind.txt").unlink()
    assert sorted(p.name for p in out.iterdir()) == FILES
    assert list(tmp_path.iterdir()) == [out]


def test_bad_input_leaves_an_earlier_run_unchanged(noisy, capsys):
    before = files(noisy.parent)
    options = ["--set", "vehicle.working_rad=[0]", "--out", str(noisy)]
    assert main(["run", "hover", *options]) == 2
    assert files(noisy.parent) == before


@pytest.mark.parametrize("name", ["thesis.tex", "summary.json"])
def test_a_folder_with_other_files_is_refused(name, tmp_path, capsys):
    """One of the names is also a name of the results."""
    out = tmp_path / "mine"
    out.mkdir()
    (out / name).write_text("precious")
    assert main(["run", "hover", *TINY, "--out", str(out)]) == 2
    assert f"{out}: holds files" in capsys.readouterr().err
    assert files(tmp_path) == {f"mine/{name}": b"precious"}


@pytest.mark.parametrize("name", ["cost $x^$ and a_b, ü & <b>"])
def test_any_printable_name_is_accepted(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("flight.yaml").write_text(yaml.safe_dump({"name": name, "settle_s": 0, "duration": 0.02}))
    assert main(["run", "flight.yaml", "--quiet"]) == 0
    (run,) = Path("runs").iterdir()
    assert summary(run)["scenario"] == name
