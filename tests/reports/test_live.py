"""Tests of the live view: same numbers, at the requested rate."""

import json
import struct

import numpy as np
import pytest

from aerodrake.cli import main
from aerodrake.flight.simulate import FlightSimulation
from aerodrake.model.vehicle.rotation import rotation_matrix
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.reports.live import LiveView

RATE = 3.0


@pytest.fixture(scope="module")
def watched(short_flight):
    """A view, its lines, and the log of the flight that it showed."""
    scenario, _ = short_flight
    flight = FlightSimulation(scenario)
    with LiveView(RATE, lambda line: None) as view:
        lines = []
        log = flight.fly(lambda simulated_s: lines.append(view.line()), RATE, view.attach)
        yield view, lines, log


def test_watching_changes_nothing(watched, short_flight):
    _, _, log = watched
    for key in set(log.signals) - {"tick_ms"}:
        np.testing.assert_array_equal(log[key], short_flight[1][key])


def test_it_is_no_faster_than_requested(watched):
    _, _, log = watched
    assert log.wall_s > 0.95 * 0.6 / RATE


def test_all_is_drawn(watched):
    meshcat = watched[0]._scene.meshcat
    for path in ("reference", "end_effector", "prediction"):
        assert meshcat.HasPath(f"/paths/{path}")
    assert meshcat.HasPath("/learning_space")
    assert meshcat.HasPath("visualizer/quadrotor_arm6/base")


def test_the_learning_space_moves_with_the_base(watched, short_flight):
    """The last frame is less than one period before the end."""
    view, _, log = watched
    placed = numbers(view._scene.meshcat._GetPackedTransform("/learning_space"))
    p_O = VehicleModel.load(short_flight[0]).p_O
    expected = log["p_B_m"][-1] + rotation_matrix(log["quaternion"][-1]) @ p_O
    np.testing.assert_allclose(placed[12:15], expected, atol=5e-3)  # By columns.


def numbers(message: bytes) -> list[float]:
    """The doubles of a MessagePack message, each behind a byte 0xcb."""
    tail = message[message.index(b"matrix") :]
    start = tail.index(b"\xcb")
    return [value for _, value in struct.iter_unpack(">cd", tail[start : start + 16 * 9])]


def test_a_line_shows_the_state_of_the_flight(watched):
    _, lines, log = watched
    assert len(lines) == 6
    assert float(lines[-1].split()[1]) == pytest.approx(1e3 * log.error_m[-1], abs=1e-3)
    assert "coordinated" in lines[-1] and lines[-1].endswith("nominal")
    assert max(map(len, lines)) + len("clover 33.0/33.0 s, ") < 80


def test_the_command_prints_the_address(tmp_path, capsys):
    arguments = ["run", "hover", "--live", "--rate", "20", "--duration", "0.1"]
    assert main([*arguments, "--set", "settle_s=0", "--quiet", "--out", str(tmp_path / "run")]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith("watch it at http://localhost:") and printed.out == ""
    summary = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert summary["exit_reason"] == "completed"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rate", "2"], "--rate: expected --live; other flights"),
        (["--live", "--rate", "2", "--lcm"], "--rate: expected "),
        (["--live", "--rate", "0"], "expected a number in [0.01, 1000], got '0'"),
        (["--live", "--rate", "fast"], "expected a number in [0.01, 1000], got 'fast'"),
        (["--live", "--rate", "nan"], "expected a number in [0.01, 1000], got 'nan'"),
    ],
)
def test_bad_rates(arguments, message, capsys):
    try:
        code = main(["run", "hover", *arguments])
    except SystemExit as stopped:
        code = stopped.code
    assert code == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
