"""`aerodrake.fly` and its result."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import aerodrake
from aerodrake.cli import main

SHORT = {"duration": 0.1, "settle_s": 0.0}


@pytest.fixture(scope="module")
def path(tmp_path_factory) -> Path:
    """A CSV of a reference."""
    path = tmp_path_factory.mktemp("mine") / "path.csv"
    path.write_text("t,x,y,z\n0,0,0.2,1.2\n1,0.1,0.2,1.2\n")
    return path


@pytest.fixture(scope="module")
def result(path) -> aerodrake.FlightResult:
    keys = {"reference.file": path, "sensors.position_noise_m": 1e-3, "seed": 3}
    return aerodrake.fly("waypoints", keys, **SHORT, quiet=True)


def signals(log) -> dict[str, np.ndarray]:
    return {key: log[key] for key in log.signals if key != "tick_ms"}


def test_a_result_has_scenario_summary_log_and_error(result):
    assert result.scenario.duration == 0.1 and result.scenario.seed == 3
    assert result.exit_reason == "completed" and result.summary["seed"] == 3
    flown = np.linalg.norm(result.log["p_E_m"] - result.log["p_Ed_m"], axis=1)
    assert result.error["max_m"] == pytest.approx(flown.max())
    assert "waypoints: completed" in str(result) and "waypoints" in repr(result)
    assert result._repr_html_().count("<svg") == 1


def test_a_name_a_path_and_a_scenario_give_the_same_flight(tmp_path, capsys):
    """Overrides are a mapping, keyword arguments, or those of the command line."""
    keys = {"sensors.position_noise_m": 1e-3}
    by_name = aerodrake.fly("hover", keys | SHORT)
    scenario = aerodrake.load_scenario("hover", **SHORT)
    by_scenario = aerodrake.fly(scenario, **keys, quiet=True)
    options = ["--duration", "0.1", "--set=settle_s=0", "--set=sensors.position_noise_m=1e-3"]
    assert main(["run", "hover", *options, "--quiet", "--out", str(tmp_path / "run")]) == 0
    by_command = aerodrake.load_run(tmp_path / "run")
    by_path = aerodrake.fly(tmp_path / "run" / "scenario.yaml", quiet=True)
    for other in (by_scenario, by_command, by_path):
        np.testing.assert_equal(signals(other.log), signals(by_name.log))


def test_a_saved_run_loads_again(result, path, tmp_path):
    """Its files have the content that was flown, whatever became of the originals."""
    content = path.read_text()
    path.write_text("overwritten")
    assert result.save(tmp_path / "a" / "run") == tmp_path / "a" / "run"
    path.write_text(content)
    again = aerodrake.load_run(tmp_path / "a" / "run")
    np.testing.assert_equal(signals(again.log), signals(result.log))
    assert dict(again.log).keys() == set(result.log) and len(again.log) == len(result.log) > 9
    assert again.summary == json.loads(json.dumps(result.summary))
    assert again.error == result.error and str(again) == str(result)
    assert Path(again.scenario.reference.file).read_text() == content
    again.save(tmp_path / "a" / "run")  # In its own place.
    np.testing.assert_equal(
        signals(aerodrake.load_run(tmp_path / "a" / "run").log), signals(result.log)
    )


@pytest.mark.usefixtures("undrawn")
def test_a_report_may_be_in_a_new_folder_or_beside_the_results(result, tmp_path):
    for folder in (tmp_path / "new", result.save(tmp_path / "run")):
        page = result.report(folder)
        assert page == folder / "report.html" and "waypoints" in page.read_text()
        assert {"tracking.png", "replay.html"} <= {path.name for path in folder.iterdir()}
        assert str(folder / "scenario.yaml") in page.read_text()


INCOMPLETE = b'{"exit_reason": "completed", "exit_cause": "", "wall_s": 1, "error": {"mean_m": 0}}'


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("summary.json", None, "summary.json: expected a readable file"),
        ("summary.json", b"", "summary.json: expected the summary of a flight"),
        ("summary.json", b"[1]", "summary.json: expected the summary of a flight"),
        ("summary.json", b'{"exit_reason": "lost"}', "expected the summary of a flight"),
        ("summary.json", b"\xff", "expected the summary of a flight"),
        ("scenario.yaml", None, "scenario.yaml: expected a readable file"),
        ("scenario.yaml", b"duration: -1", "scenario.yaml: duration: expected a number in"),
        ("log.npz", None, "log.npz: expected a readable file"),
        ("summary.json", INCOMPLETE, "summary.json: expected the summary of a flight"),
        ("log.npz", b"", "log.npz: expected the log of a flight"),
        ("log.npz", b"PK\x03\x04", "log.npz: expected the log of a flight"),
    ],
)
def test_a_damaged_run_is_refused(result, name, content, message, tmp_path):
    folder = result.save(tmp_path / "run")
    (folder / name).unlink()
    if content is not None:
        (folder / name).write_bytes(content)
    with pytest.raises(aerodrake.BadInput, match=message):
        aerodrake.load_run(folder)


def test_a_truncated_log_is_refused(result, tmp_path):
    """Its directory may be intact, and one of its arrays not."""
    path = result.save(tmp_path / "run") / "log.npz"
    content = path.read_bytes()
    middle = len(content) // 2
    for damaged in (content[:middle], content[:middle] + b"\0" * 99 + content[middle + 99 :]):
        path.write_bytes(damaged)
        with pytest.raises(aerodrake.BadInput, match="log.npz: expected the log of a flight"):
            aerodrake.load_run(path.parent)


@pytest.mark.parametrize(
    ("arguments", "keys", "message"),
    [
        (("clovr",), {}, "clovr: no such scenario; did you mean 'clover'"),
        (("clover", {"mpc.horizn": 3}), {}, "clover: mpc.horizn: unknown key; did you mean"),
        (("clover",), {"duration": -3}, "clover: duration: expected a number in"),
        ((3,), {}, "fly: scenario: expected Scenario or str or PathLike, got 3"),
        (("hover",), {"view": True}, "fly: view: expected LiveView or None, got True"),
        (("hover",), {"lcm": 3}, "fly: lcm: expected str or None, got 3"),
        (("hover",), {"quiet": "no"}, "fly: quiet: expected bool, got 'no'"),
        (("hover", [3]), {}, r"fly: overrides: expected Mapping or None, got \[3\]"),
    ],
)
def test_bad_input_names_what_was_given(arguments, keys, message):
    with pytest.raises(aerodrake.BadInput, match=message) as refused:
        aerodrake.fly(*arguments, **keys)
    assert "--" not in str(refused.value)


def test_a_folder_is_named_by_a_string_or_path(result):
    for function in (result.save, result.report, aerodrake.load_run):
        with pytest.raises(aerodrake.BadInput, match="folder: expected str or PathLike, got None"):
            function(None)


def test_a_folder_that_cannot_be_written_is_named(result, tmp_path):
    (tmp_path / "file").touch()
    for write in (result.save, result.report):
        with pytest.raises(aerodrake.BadInput) as refused:
            write(tmp_path / "file")
        assert str(tmp_path / "file") in str(refused.value)


def test_the_package_is_imported_lazily():
    """Every public name exists, and none of them is imported before it is used."""
    heavy = "{'numpy', 'pydrake', 'torch', 'matplotlib'} & {*sys.modules}"
    code = f"import sys, aerodrake; assert not {heavy}; from aerodrake import *"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_public_names_are_all_listed():
    assert {*aerodrake.__all__} == {*dir(aerodrake)}
    for name in ("fly", "compare", "sweep", "identify", "graph", "load_scenario", "load_run"):
        assert getattr(aerodrake, name).__doc__
    assert aerodrake.__version__
    packages = {path.parent.name for path in Path(aerodrake.__file__).parent.glob("*/__init__.py")}
    assert not packages & {*aerodrake.__all__}
