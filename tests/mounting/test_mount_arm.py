"""Vehicles of mounted arms: scaled, given and repeated."""

import shlex
from argparse import ArgumentParser
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RollPitchYaw

from aerodrake.commands.mount import add_arguments
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.mounting.folder import write_vehicle
from aerodrake.mounting.request import Request
from aerodrake.mounting.sizing import Given, Multirotor
from aerodrake.scenario.load import load_scenario
from aerodrake.support.errors import BadInput
from tests.arm_urdfs import serial_arm


@pytest.fixture(scope="module")
def request_(tmp_path_factory) -> Request:
    path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_text(serial_arm("zxxx", 0.15))
    return Request(path)


def mounted(request: Request, folder: Path) -> VehicleModel:
    write_vehicle(request, folder)
    return VehicleModel.load(load_scenario(str(folder / "arm.yaml")))


@pytest.fixture(scope="module")
def full(request_, tmp_path_factory) -> tuple[Path, VehicleModel]:
    folder = tmp_path_factory.mktemp("out") / "full"
    return folder, mounted(request_, folder)


def test_a_scaled_arm_is_similar(request_, full, tmp_path):
    """Lengths by 1/2, masses by 1/8, and so the arm's moments of gravity by 1/16."""
    _, whole = full
    half = mounted(replace(request_, scale=(0.5,)), tmp_path / "half")
    assert half.working == pytest.approx(whole.working, abs=0.02)
    assert half.mass == pytest.approx(whole.mass / 8, rel=0.05)
    assert half.effort == pytest.approx(whole.effort / 16)
    assert half.trim_torque == pytest.approx(whole.trim_torque / 16, abs=2e-3)
    hover = [
        vehicle.mass
        * 9.81
        / (len(vehicle.rotors.names) * load_scenario(path).vehicle.rotor.max_thrust_n)
        for vehicle, path in ((whole, full[0] / "arm.yaml"), (half, tmp_path / "half" / "arm.yaml"))
    ]
    assert all(0.42 < share <= 0.47 for share in hover)


def test_the_same_arm_gives_the_same_files(request_, full, tmp_path):
    write_vehicle(request_, tmp_path / "again")
    for name in ("arm.urdf", "arm.yaml", "mounting.json"):
        assert (tmp_path / "again" / name).read_bytes() == (full[0] / name).read_bytes()


def test_the_scenario_names_its_command():
    given = Given(base_mass=3.0, rotors=8)
    request = Request(
        Path("a/my arm.urdf"), "tcp", scale=(0.5, 1.0), mount=(0, 0, -0.1), given=given
    )
    expected = "'my arm.urdf' --tool tcp --scale 0.5 1 --mount 0 0 -0.1 --base-mass 3 --rotors 8"
    assert request.command == f"aerodrake mount {expected}"
    parser = ArgumentParser()
    add_arguments(parser)
    parsed = parser.parse_args(shlex.split(request.command)[2:])
    assert (parsed.tool, parsed.scale, parsed.mount) == ("tcp", [0.5, 1], [0, 0, -0.1])
    assert Request(Path("arm.urdf")).command == "aerodrake mount arm.urdf"


def test_given_choices_are_followed(request_, tmp_path):
    given = Given(base_mass=3.0, rotors=8, radius=0.7, max_thrust=9.0)
    chosen = {"tool": "link_3", "mount": (0.1, 0.0, -0.2, np.pi, 0.0, 0.5), "given": given}
    vehicle = mounted(replace(request_, **chosen), tmp_path / "given")
    assert vehicle.joints == 3 and len(vehicle.rotors.names) == 8
    assert np.hypot(*vehicle.rotors.p_B[:, :2].T) == pytest.approx(np.full(8, 0.7), rel=1e-4)
    frame = vehicle.plant.GetFrameByName("link_0")
    context = vehicle.plant.CreateDefaultContext()
    X = vehicle.plant.CalcRelativeTransform(context, vehicle.plant.GetFrameByName("base"), frame)
    assert X.translation() == pytest.approx([0.1, 0, -0.2])
    expected = RollPitchYaw(np.pi, 0, 0.5).ToRotationMatrix()
    assert X.rotation().matrix() == pytest.approx(expected.matrix(), abs=1e-9)


@pytest.mark.parametrize(
    ("mass", "advice"),
    [(1e-3, "got one of 0.001 kg; scale it"), (900, "900 kg; mount a part of it with --root, or")],
)
def test_an_arm_for_no_rotors_is_refused(mass, advice, request_, tmp_path):
    """The factor of the advice gives masses that rotors can carry."""
    heavy = replace(request_, scale=(1.0, mass))
    with pytest.raises(BadInput, match="for . rotors of 0.1 to 1000 N each") as caught:
        write_vehicle(heavy, tmp_path / "out")
    assert advice in str(caught.value)
    kg = float(str(caught.value).split()[-1]) ** 3
    assert 0.1 < 0.9 * Multirotor.for_arm(kg, 0.5, Given()).max_thrust < 900


def test_a_refused_arm_leaves_nothing(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text(serial_arm("z"))  # Its tool is on the axis of its joint.
    with pytest.raises(BadInput, match="tool: expected a tool that the joints move"):
        write_vehicle(Request(path), tmp_path / "out")
    assert [file.name for file in tmp_path.iterdir()] == ["arm.urdf"]
