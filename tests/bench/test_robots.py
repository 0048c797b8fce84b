"""Real arms as the bench mounts and flies them, with a package of our own in their place."""

import json
from importlib.metadata import PackageNotFoundError
from types import SimpleNamespace

import pytest

from aerodrake.analysis.margins import StabilityLimit
from aerodrake.bench import robots
from aerodrake.bench.robots import ARMS, PACKAGE, RobotArm, installed_urdf
from aerodrake.bench.robots_report import robots_table
from aerodrake.cli import main
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import frame_link, serial_arm

LIMIT = StabilityLimit(0.0214, 3.0)


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package with one arm, and a linear analysis that takes no time."""
    path = tmp_path / "package" / "desk" / "urdf" / "arm.urdf"
    path.parent.mkdir(parents=True)
    path.write_text(serial_arm("zxx", end=frame_link("tcp", "link_3")))
    margin = SimpleNamespace(name="base_delay", upper=LIMIT)
    analysis = SimpleNamespace(is_stable=True, margins=[margin])
    monkeypatch.setattr(robots, "analyze_loop", lambda scenario: analysis)

    def files(name):
        assert name == PACKAGE
        return [SimpleNamespace(match=path.match, locate=lambda: path)]

    monkeypatch.setattr(robots, "files", files)
    return path


def test_the_command_mounts_and_flies(package, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(robots, "ARMS", (RobotArm("Desk, left", "desk/urdf/arm.urdf"),))
    monkeypatch.setattr("aerodrake.commands.bench.QUICK_FLOWN_S", 0.1)
    out, copy = tmp_path / "out", tmp_path / "copy.json"
    assert main(["bench", "--robots", "--quick", "--out", str(out), "--json", str(copy)]) == 0
    shown = capsys.readouterr().out
    assert "Desk, left" in shown and " 21" in shown and "note" not in shown.lower()
    figures = json.loads((out / "robots.json").read_text())
    assert figures == json.loads(copy.read_text())
    (arm,) = figures["arms"]
    assert arm["joints"] == 3 and arm["exit_reason"] == "completed"
    assert 0 < arm["error"]["mean_m"] < 1e-3 and arm["delay_margin_s"] == LIMIT.value
    assert (out / "desk_left" / "arm.yaml").exists()


def test_a_missing_package_or_file_is_named(package, monkeypatch):
    with pytest.raises(BadInput, match="expected no/such.urdf in example-robot-data"):
        installed_urdf(RobotArm("none", "no/such.urdf"))

    def files(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(robots, "files", files)
    with pytest.raises(BadInput, match=r"pip install 'aerodrake\[robots\]'"):
        installed_urdf(ARMS[0])


def test_a_lost_flight_is_shown():
    arm = {"name": "A", "joints": 2, "arm_kg": 1.0, "base_kg": 2.2, "reach_m": 0.5}
    ended = {"exit_reason": "lost", "exit_cause": "tilt", "error": {"mean_m": None, "max_m": None}}
    margins = {"torque_at_limit": 0.25, "is_stable": False, "delay_margin_s": None}
    line = robots_table({"arms": [arm | ended | margins]}).splitlines()[-1]
    assert " ".join(line.split()) == "A 2 1.0 2.2 0.50 - - 25 % unstable lost: tilt"


def test_names_and_files_of_the_arms_are_different():
    assert len(ARMS) >= 10
    assert len({arm.name for arm in ARMS}) == len({arm.urdf for arm in ARMS}) == len(ARMS)
