"""Files, output and exit codes of `aerodrake mount`."""

import json
from types import SimpleNamespace

import pytest

import aerodrake
import aerodrake.api.mount
from aerodrake.cli import main
from tests.arm_urdfs import frame_link, serial_arm


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    path = tmp_path_factory.mktemp("arm") / "desk arm.urdf"
    path.write_text(serial_arm("zxx", end=frame_link("tcp", "link_3")))
    return path


def test_a_mounted_arm_hovers(arm, tmp_path, capsys, monkeypatch):
    out = tmp_path / "out"
    assert main(["mount", str(arm), "--out", str(out), "--base-mass", "2", "--rotors", "6"]) == 0
    shown = capsys.readouterr().out
    assert "tool: link tcp" in shown and "2 kg, 6 rotors" in shown
    assert "hover: completed; a push of 1.4 N moves the tool by" in shown
    assert "analysis: stable" in shown and "delay margin: unstable with 2" in shown
    assert "missing acceleration limits are set" in shown
    names = sorted(path.name for path in out.iterdir())
    assert names == ["desk_arm.urdf", "desk_arm.yaml", "mounting.json"]
    mounting = json.loads((out / "mounting.json").read_text())
    assert mounting["joints"] == ["joint_1", "joint_2", "joint_3"]
    scenario = aerodrake.load_scenario(out / "desk_arm.yaml")
    assert scenario.reference.kind == "clover" and scenario.vehicle.base_position_m[2] >= 1.5

    result = SimpleNamespace(is_stable=False, sentence="unstable", margins={})
    monkeypatch.setattr(aerodrake.api.mount, "analyze", lambda *_, **__: result)
    (out / "of_before.txt").touch()
    assert main(["mount", str(arm), "--out", str(out), "--quiet"]) == 1
    assert not (out / "of_before.txt").exists() and not capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--tool", "tpc"], "--tool: expected a link, got 'tpc'; did you mean 'tcp'?"),
        (["--root", "link_9"], "--root: expected a link, got 'link_9'"),
        (["--scale", "0"], "argument --scale: expected a number in [0.001, 1000]"),
        (["--scale", "1", "2", "3"], "--scale: expected a factor of lengths"),
        (["--mount", "0", "0"], "--mount: expected x, y, z in m"),
        (["--mount", "nan", "0", "0"], "argument --mount: expected a number in [-10, 10]"),
        (["--scale", "1", "500"], "got one of 400 kg; mount a part of it with --root, or scale it"),
        (
            ["--base-mass", "9", "--max-thrust", "20"],
            "--max-thrust: expected rotors that hover with",
        ),
        (["--rotors", "5"], "--rotors: expected an even number, got 5"),
        (["--max-thrust", "0"], "argument --max-thrust: expected a number in [0.1, 1000]"),
    ],
)
def test_bad_input(options, message, arm, tmp_path, capsys):
    try:
        code = main(["mount", str(arm), "--out", str(tmp_path / "out"), *options])
    except SystemExit as stopped:
        code = stopped.code
    shown = capsys.readouterr().err
    assert code == 2 and message in shown.splitlines()[-1] and "Traceback" not in shown
    assert not (tmp_path / "out").exists()


def test_other_files_are_kept(arm, tmp_path, capsys):
    (tmp_path / "thesis.tex").touch()
    assert main(["mount", str(arm), "--out", str(tmp_path)]) == 2
    assert "holds files" in capsys.readouterr().err and (tmp_path / "thesis.tex").exists()
