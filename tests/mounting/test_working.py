"""Working configurations of arms with two to seven joints."""

import numpy as np
import pytest

from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.mounting.mount_arm import mount_arm
from aerodrake.mounting.request import Request
from aerodrake.scenario.load import load_scenario
from tests.arm_urdfs import serial_arm

ARMS = {
    "two": serial_arm("xx", 0.2),
    "four_offset": serial_arm("zxxz", 0.15, offset=0.03),
    "five": serial_arm("zxxxz"),
    "six_continuous": serial_arm("zxxzxz", kind="continuous"),
    "seven": serial_arm("zxzxzxz", 0.1, 0.15),
}


@pytest.fixture(scope="module", params=ARMS)
def mounted(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp(request.param)
    path = folder / f"{request.param}.urdf"
    path.write_text(ARMS[request.param])
    (folder / "out").mkdir()
    result = mount_arm(Request(path), folder / "out")
    scenario = load_scenario(str(folder / "out" / f"{request.param}.yaml"))
    return result, VehicleModel.load(scenario)


def test_the_configuration_is_good(mounted):
    result, vehicle = mounted
    working = result.working
    assert working.dexterity > 0.6 and working.margin > 0.35 and working.torque < 0.35
    assert working.overlap is None
    assert vehicle.working == pytest.approx(working.q)
    # In front of the base, below it, and pointing down.
    x, y, z = vehicle.p_O
    assert abs(x) < 1e-3 and -1e-3 < y < -0.8 * z and vehicle.tool_axis[2] < -0.9


def test_measures_are_those_of_the_vehicle(mounted):
    result, vehicle = mounted
    posture = result.working.posture
    assert np.linalg.norm(posture.tool) == pytest.approx(np.linalg.norm(vehicle.p_O), rel=0.3)
    assert posture.torque == pytest.approx(vehicle.trim_torque, abs=1e-6)
    torques = np.abs(vehicle.trim_torque) / vehicle.effort
    assert result.working.torques == pytest.approx(torques, abs=1e-6)
    moment = np.hypot(*vehicle.trim_wrench[1:3]) / 9.81
    assert np.hypot(*posture.offset) * result.vehicle.arm.mass == pytest.approx(moment, abs=1e-6)


def test_the_base_is_sized_for_the_inertia_of_the_arm(mounted):
    result, vehicle = mounted
    plant = vehicle.plant
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, [1, 0, 0, 0, 0, 0, 0, *vehicle.working])
    base = result.vehicle.multirotor.inertia
    moments = plant.CalcMassMatrix(context)[:2, :2] - np.diag(base[:2])
    inertia = np.linalg.eigvalsh(moments)[-1]
    assert result.working.inertia == pytest.approx(inertia, rel=1e-3)
    assert inertia < 2.02 * base[0]


def test_it_can_land(mounted):
    _, vehicle = mounted
    heights = vehicle.ground_geometry.heights(vehicle.tucked)
    assert heights.min() > vehicle.feet_m + 0.09
