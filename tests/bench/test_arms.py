"""Arms with other numbers of joints: same working position of the end-effector; they fly."""

import numpy as np
import pytest

from aerodrake.bench.arms import with_joints
from aerodrake.bench.scaling import JOINTS
from aerodrake.bench.ticks import record_ticks
from aerodrake.model.vehicle.vehicle import VehicleModel
from aerodrake.scenario import Scenario


@pytest.mark.parametrize("joints", JOINTS)
def test_the_working_position_is_unchanged(joints, scenario, vehicle, tmp_path):
    changed = with_joints(scenario, joints, tmp_path / "arm.urdf")
    other = VehicleModel.load(changed)
    assert other.joints == joints
    assert other.joint_names[: min(joints, 6)] == vehicle.joint_names[:joints]
    np.testing.assert_allclose(other.p_O, vehicle.p_O, atol=1e-9)
    assert other.mass == pytest.approx(vehicle.mass + 0.005 * max(0, joints - 6))
    assert (other.velocity == 3).all() and (other.acceleration == 15).all()


def test_the_same_number_of_joints_changes_nothing(scenario, vehicle, tmp_path):
    other = VehicleModel.load(with_joints(scenario, vehicle.joints, tmp_path / "arm.urdf"))
    np.testing.assert_array_equal(other.inertia, vehicle.inertia)
    np.testing.assert_array_equal(other.working, vehicle.working)


@pytest.mark.parametrize("joints", [3, 9])
def test_other_arms_fly(joints, tmp_path):
    scenario = Scenario(duration=0.1, settle_s=0.0)
    recorded = record_ticks(with_joints(scenario, joints, tmp_path / "arm.urdf"))
    assert len(recorded.inputs) == 5
    assert recorded.formulation.A.shape[1] == 15 * (3 + joints)
