"""Rotors that cannot control the vehicle are refused; a yawed frame makes no difference."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from aerodrake.model.low_level.thrust_allocation import ThrustAllocation
from aerodrake.model.vehicle.rotors import INDEPENDENT, Rotors
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Rotor
from aerodrake.support.errors import BadInput
from tests.urdfs import HEXAROTOR, changed, vehicle_refusal, with_urdf

RING = np.array([[np.cos(a), np.sin(a)] for a in np.arange(6) * np.pi / 3])
QUAD = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])


def rotors(xy: np.ndarray, spin: list[int]) -> Rotors:
    names = tuple(f"rotor_{i}_{'ccw' if s > 0 else 'cw'}" for i, s in enumerate(spin))
    return Rotors(names, np.column_stack([xy, np.zeros(len(xy))]), np.array(spin, dtype=float))


@pytest.mark.parametrize(
    ("xy", "spin", "missing"),
    [
        (QUAD, [1, -1, 1, -1], ""),
        (0.2 * QUAD + 0.1, [1, -1, 1, -1], ""),
        (QUAD, [1, 1, 1, 1], "yaw"),
        (QUAD, [1, 1, -1, -1], "yaw"),
        (QUAD, [1, -1, -1, 1], "yaw"),
        (QUAD + [[0.02, 0], [0, 0], [0, 0], [0, 0.02]], [1, 1, -1, -1], "yaw"),
        (RING, [1, -1, 1, -1, 1, -1], ""),
        (RING, [1, 1, -1, -1, 1, -1], ""),
        (RING, [-1] * 6, "yaw"),
        (np.repeat(RING[::2], 2, axis=0), [1, -1] * 3, ""),
        (np.repeat(RING[::2], 2, axis=0), [1, 1, -1, -1, -1, -1], "yaw"),
        (RING * [1, 0], [1, -1, 1, -1, 1, -1], "roll and pitch"),
        (RING * [1, 1e-3], [1, -1, 1, -1, 1, -1], "roll and pitch"),
        (RING * 0, [1, -1, 1, -1, 1, -1], "roll and pitch"),
    ],
)  # fmt: skip
def test_missing_torque(xy, spin, missing):
    problem = rotors(xy, spin).missing_torque()
    assert missing in problem and bool(problem) == bool(missing)


@settings(max_examples=60)
@given(
    xy=st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=4, max_size=8),
    spin=st.lists(st.sampled_from((-1, 1)), min_size=8, max_size=8),
)
def test_accepted_rotors_produce_every_wrench(xy, spin):
    """Their mixer, with rows of unit norm, has full rank with a margin."""
    fleet = rotors(np.array(xy), spin[: len(xy)])
    if fleet.missing_torque():
        return
    centred = rotors(np.array(xy) - np.mean(xy, axis=0), spin[: len(xy)])
    mixer = centred.mixer(0.02)
    mixer /= np.linalg.norm(mixer, axis=1, keepdims=True)
    assert np.linalg.matrix_rank(fleet.mixer(0.02), tol=1e-12) == 4 or np.ptp(xy) < 1e-9
    assert np.linalg.svd(mixer, compute_uv=False)[-1] > INDEPENDENT**2 / 4


def spinning(directions: str) -> str:
    """Returns the hexarotor with other directions of rotation, + for counter-clockwise."""
    text = HEXAROTOR
    for i, d in enumerate(directions, start=1):
        old = f"rotor_{i}_{'ccw' if i % 2 else 'cw'}"
        text = text.replace(f'"{old}"', f'"rotor_{i}_{"ccw" if d == "+" else "cw"}"')
    return text


@pytest.mark.parametrize("directions", ["++++++", "------", "+++---"])
def test_rotors_without_yaw_torque_are_refused(directions, tmp_path):
    """Rotors 1 to 3 are ahead of 4 to 6: their drag is proportional to the pitch torque."""
    text = spinning(directions)
    if directions == "+++---":
        for i, x in enumerate((0.31, 0.31, 0.31, -0.31, -0.31, -0.31), start=1):
            line = next(row for row in text.splitlines() if f'"rotor_{i}_' in row)
            y = (-0.3, 0.0, 0.3)[i % 3]
            text = text.replace(line, f'{line.partition(" xyz")[0]} xyz="{x} {y} 0"/>')
    message = vehicle_refusal(text, tmp_path)
    assert "robot.urdf: expected directions of rotation, _ccw and _cw, with which" in message
    assert "yaw torque" in message and "rotor_6_" in message


FRAME = 'name="rotor_1_ccw" link="base" xyz="0.311769 0.180000 0.03" rpy="0 0 0"'


@pytest.mark.parametrize(
    ("new", "message"),
    [
        (
            FRAME.replace('"0 0 0"', '"0.1 0 0"'),
            r"rotor_1_ccw: .* of base, got \(0, -0.0998, 0.995",
        ),
        (FRAME.replace('"0 0 0"', '"3.14159265 0 0"'), r"rotor_1_ccw: .* z axis.*, -1\)"),
        (FRAME.replace('"base"', '"hand"'), "rotor_1_ccw: expected the link base, got hand"),
        (FRAME.replace("ccw", "CCW"), "frame rotor_1_CCW: expected .* ends in _ccw or _cw"),
    ],
)
def test_frames_of_rotors(new, message, tmp_path):
    with pytest.raises(BadInput, match=message):
        VehicleModel.load(with_urdf(changed(HEXAROTOR, FRAME, new), tmp_path))


def test_a_frame_yawed_about_its_own_axis_changes_nothing(tmp_path):
    ours = VehicleModel.load(with_urdf(HEXAROTOR, tmp_path))
    yawed = changed(HEXAROTOR, FRAME, FRAME.replace('"0 0 0"', '"0 0 2.5"'))
    other = VehicleModel.load(with_urdf(yawed, tmp_path))
    for torque_ratio in (0.015, 0.02):
        mixers = [vehicle.rotors.mixer(torque_ratio) for vehicle in (ours, other)]
        np.testing.assert_array_equal(*mixers)
    np.testing.assert_array_equal(ours.trim_wrench, other.trim_wrench)


def test_rotors_beside_the_base_are_refused_by_name(tmp_path):
    text = HEXAROTOR
    for row in [row for row in text.splitlines() if '<frame name="rotor_' in row]:
        start, _, rest = row.partition('xyz="')
        x, rest = rest.split(" ", 1)
        text = text.replace(row, f'{start}xyz="{float(x) + 1} {rest}')
    vehicle = VehicleModel.load(with_urdf(text, tmp_path))
    with pytest.raises(BadInput, match="all around the base's origin; .* rotor_1_ccw.* pull down"):
        ThrustAllocation.make(vehicle, Rotor())


@pytest.mark.parametrize("directions", ["+++++-", "++++--"])
def test_directions_that_do_not_balance_are_refused(directions, tmp_path):
    """Lift without yaw torque would need negative thrusts, though yaw torque is independent."""
    vehicle = VehicleModel.load(with_urdf(spinning(directions), tmp_path))
    with pytest.raises(BadInput, match="directions of rotation.* balance in hover; .* pull down"):
        ThrustAllocation.make(vehicle, Rotor())


def test_three_rotors_are_too_few(tmp_path):
    rows = [
        row for row in HEXAROTOR.splitlines() if not any(f"rotor_{i}" in row for i in (4, 5, 6))
    ]
    message = vehicle_refusal("\n".join(rows), tmp_path)
    assert "expected four or more frames" in message
    assert message.endswith("got rotor_1_ccw, rotor_2_cw, rotor_3_ccw")
