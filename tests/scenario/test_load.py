"""Loading and saving of scenario files, and refusal of invalid ones."""

import dataclasses
import os
import time
from pathlib import Path

import pytest

from aerodrake.model.reference.waypoints import read_waypoints
from aerodrake.scenario import Clover, Scenario, Waypoints
from aerodrake.scenario.load import (
    MAX_FILE_BYTES,
    load_scenario,
    packaged_scenarios,
    save_scenario,
)
from aerodrake.scenario.schema import as_mapping, build
from tests.refusals import refuses

# Reading.


@pytest.mark.parametrize("name", packaged_scenarios())
def test_packaged_scenarios_survive_a_round_trip(name):
    scenario = load_scenario(name)
    assert scenario.name == name and scenario.source.endswith(f"{name}.yaml")
    rebuilt = build(Scenario, as_mapping(scenario), "f.yaml")
    assert dataclasses.replace(rebuilt, source=scenario.source) == scenario


def test_packaged_waypoints_are_found_from_any_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    times, points = read_waypoints(load_scenario("waypoints").reference.file)
    assert times[0] == 0
    assert list(points[0]) == [0, 0.2, 1.2]


def test_an_unknown_name_is_refused_with_the_nearest():
    assert refuses("clovr").startswith("clovr: no such scenario; did you mean 'clover'? (valid: ")


def test_reads_a_file_by_its_path(write, tmp_path, monkeypatch):
    path = write("duration: 4\nreference: {kind: clover, lap_s: 30}\n")
    scenario = load_scenario(path)
    assert scenario.duration == 4 and scenario.reference == Clover(lap_s=30)
    assert (scenario.name, scenario.source) == ("flight", path)
    monkeypatch.chdir(tmp_path)
    assert load_scenario("flight.yaml").duration == load_scenario("./flight.yaml").duration == 4
    assert load_scenario(write("name: mine\nseed: 1\n")).name == "mine"


def test_a_bare_off_is_a_string(write):
    assert load_scenario(write("residual: {mode: off}\n")).residual.mode == "off"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "expected a mapping of scenario keys to values, got an empty file"),
        ("# nothing\n", "expected a mapping of scenario keys to values, got an empty file"),
        ("---\n", "expected a mapping of scenario keys to values, got an empty file"),
        ("- 3\n", "expected a mapping of scenario keys to values"),
        ("3\n", "expected a mapping of scenario keys to values"),
        ("hello\n", "expected a mapping of scenario keys to values"),
        ("duration: 3\nduration: 4\n", "duration"),
        ("mpc: {horizon: 3, horizon: 5}\n", "horizon"),
        ("duration: 3\n---\nduration: 4\n", "expected YAML; line 2"),
        ("duration: 3\n  seed: 1\n", "expected YAML; line 2"),
        ("\tduration: 3\n", "expected YAML; line 1"),
        ("duration: [3\n", "expected YAML; line "),
        ("duration: *nowhere\n", "duration: line 1: expected a value without anchors and aliases"),
        (
            "duration: !!python/object/apply:os.getcwd []\n",
            "duration: line 1: expected a value without",
        ),
        ("duration: !unknown 3\n", "duration: line 1: expected a value without a tag"),
        ("duration: \x07\n", "expected YAML; "),
        ("duration: 2020-01-01\n", "duration: expected a number"),
        ("duration: !!binary aGVsbG8=\n", "duration: line 1: expected a value without"),
        ("? [a, b]\n: 1\n", "line 1"),
        ("~: 1\n", "key"),
        ("3: 1\n", "key"),
        ("_duration: 3\n", "_duration: unknown key; did you mean 'duration'?"),
        ("<<: {duration: 3}\n", "<<"),
    ],
)
def test_invalid_text_is_refused_with_its_file(write, text, expected):
    path = write(text)
    message = refuses(path)
    assert message.startswith(f"{path}: ") and expected in message


@pytest.mark.parametrize(
    "content", [b"\x00\x01\x02\xff\xfe", b"\x89PNG\r\n\x1a\n", "duration: 3".encode("utf-16")]
)
def test_a_binary_file_is_refused(write, content):
    path = write(content)
    assert refuses(path).startswith(f"{path}: expected ")


def test_missing_files_are_refused(tmp_path):
    missing = str(tmp_path / "missing.yaml")
    assert refuses(missing) == f"{missing}: expected a readable file: No such file or directory"
    folder = tmp_path / "folder.yaml"
    folder.mkdir()
    assert refuses(str(folder)) == f"{folder}: expected a readable file: Is a directory"
    assert "File name too long" in refuses("x" * 300 + ".yaml")


def test_pipes_devices_and_loops_are_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    (tmp_path / "zero.yaml").symlink_to("/dev/zero")
    (tmp_path / "loop.yaml").symlink_to("loop.yaml")
    for name, problem in (
        ("pipe.yaml", "expected a file, got a pipe or a device"),
        ("zero.yaml", "expected a file, got a pipe or a device"),
        ("loop.yaml", "Too many levels of symbolic links"),
    ):
        assert problem in refuses(str(tmp_path / name))


def nested(text: str, template: str, levels: int) -> str:
    """Returns a YAML bomb, in which each level has nine references to the level before."""
    lines = [f"a0: &a0 {text}"]
    for i in range(1, levels):
        lines.append(f"a{i}: &a{i} " + template.format(",".join([f"*a{i - 1}"] * 9)))
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize(
    "text",
    [
        "# " + "x" * MAX_FILE_BYTES,
        "duration: " + "9" * (MAX_FILE_BYTES - 100),
        "duration: [" + "1," * (MAX_FILE_BYTES // 2 - 100) + "1]",
        "duration: " + "[" * (MAX_FILE_BYTES - 100),
        "duration: " + "[" * 20000 + "]" * 20000,
        "duration: " + "{a: " * 20000 + "1" + "}" * 20000,
        "mpc: &a\n  k_e: *a\n",
        "model: {kind: " + "k" * (MAX_FILE_BYTES - 100) + "}",
        '"' + "k" * (MAX_FILE_BYTES - 100) + '": 1',
        nested("[lol,lol]", "[{}]", 30) + "duration: *a29\n",
        "mpc:\n  " + nested("[lol,lol]", "[{}]", 30).replace("\n", "\n  "),
        nested("{x: 1}", "{{<<: [{}]}}", 8),
    ],
    ids=["large", "digits", "list", "open", "lists", "maps", "loop", "value", "key", "aliases",
         "inner_aliases", "merges"],
)  # fmt: skip
def test_hostile_files_are_refused_at_once(write, text):
    path = write(text)
    start = time.process_time()
    assert refuses(path).startswith(f"{path}: ")
    assert time.process_time() - start < 10  # Includes other work of this process.


# Files beside the scenario.


def test_files_are_relative_to_the_scenario_file_or_the_working_directory(
    write, tmp_path, monkeypatch
):
    path = write("reference: {kind: waypoints, file: points.csv}\n", "inside/flight.yaml")
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    relative = os.path.relpath(path)
    for given in (path, relative):
        assert load_scenario(given).reference == Waypoints(str(tmp_path / "inside" / "points.csv"))
    overridden = load_scenario(path, {"reference.file": "points.csv"})
    assert Path(overridden.reference.file).absolute() == tmp_path / "elsewhere" / "points.csv"
    absolute = write("reference: {kind: waypoints, file: /somewhere/points.csv}\n")
    assert load_scenario(absolute).reference.file == "/somewhere/points.csv"
    assert load_scenario(absolute).vehicle.robot == Scenario().vehicle.robot


# Writing.


@pytest.mark.parametrize("name", packaged_scenarios())
def test_saved_scenarios_are_equal(name, tmp_path):
    first = load_scenario(name)
    second = load_scenario(str(save_scenario(first, tmp_path)))
    portable = {"reference": first.reference, "source": first.source}
    assert dataclasses.replace(second, **portable) == first
    again = tmp_path / "again"
    again.mkdir()
    text = save_scenario(second, again).read_text()
    assert text == (tmp_path / "scenario.yaml").read_text()


def test_saved_scenarios_are_self_contained(write, tmp_path, monkeypatch):
    path = write("reference: {kind: waypoints, file: points.csv}\n", "origin/flight.yaml")
    points = Path(write("t,x,y,z\n0,0,0.2,1.2\n5,0,0.3,1.2\n", "origin/points.csv"))
    before = read_waypoints(points)
    run = tmp_path / "run"
    run.mkdir()
    save_scenario(load_scenario(path), run)
    for file in (path, points):
        os.remove(file)
    moved = run.rename(tmp_path / "moved")
    monkeypatch.chdir("/")
    loaded = load_scenario(str(moved / "scenario.yaml"))
    assert loaded.name == "flight"
    for ours, theirs in zip(read_waypoints(loaded.reference.file), before, strict=True):
        assert (ours == theirs).all()


@pytest.mark.parametrize(
    "name", ["off", "1e3", "null", "2020-01-01", "1:30", "a: b", "ü", "'x", "7"]
)
def test_names_survive_being_saved(name, tmp_path):
    path = save_scenario(Scenario(name=name), tmp_path)
    assert load_scenario(str(path)).name == name
