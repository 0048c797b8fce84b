"""Constant errors of the sensors."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from aerodrake.model.sensing.sensor_errors import SensorErrors, biased
from aerodrake.model.vehicle.state import VehicleState, split_state
from aerodrake.scenario import AttitudeSensor, JointSensors, PositionSensor, Sensors
from aerodrake.support.errors import ScenarioError

JOINTS = 3
ATTITUDE = Rotation.from_euler("xyz", [0.3, -0.2, 0.5])


def state() -> np.ndarray:
    x = np.linspace(-1, 1, VehicleState.size(JOINTS))
    x[:4] = ATTITUDE.as_quat(scalar_first=True)
    return x


def test_each_bias_applies_to_its_own_part_in_its_own_frame():
    config = Sensors(
        position=PositionSensor(bias_m=(0.1, 0.2, 0.3)),
        attitude=AttitudeSensor(bias_rad=(0.01, -0.02, 0.03)),
        joints=JointSensors(zero_rad=(0.1, 0.0, -0.1)),
    )
    rate_bias = np.array([0.04, 0.05, 0.06])
    measured = split_state(biased(SensorErrors.make(config, JOINTS), rate_bias, state()))
    true = split_state(state())
    np.testing.assert_allclose(measured.p_B - true.p_B, [0.1, 0.2, 0.3], atol=1e-15)
    np.testing.assert_allclose(measured.q - true.q, [0.1, 0, -0.1], atol=1e-15)
    np.testing.assert_allclose(measured.omega_W - true.omega_W, ATTITUDE.apply(rate_bias))
    turn = ATTITUDE.inv() * Rotation.from_quat(measured.quaternion, scalar_first=True)
    np.testing.assert_allclose(turn.as_rotvec(), [0.01, -0.02, 0.03], atol=1e-12)
    np.testing.assert_array_equal(measured.v_B, true.v_B)
    np.testing.assert_array_equal(measured.qdot, true.qdot)


def test_no_bias_changes_no_bit():
    none = SensorErrors.make(Sensors(), JOINTS)
    np.testing.assert_array_equal(biased(none, np.zeros(3), state()), state())


def test_one_zero_holds_for_all_joints():
    config = Sensors(joints=JointSensors(zero_rad=(0.1,)))
    np.testing.assert_array_equal(SensorErrors.make(config, JOINTS).zero, np.full(JOINTS, 0.1))


@pytest.mark.parametrize("count", [0, 2, 4])
def test_another_number_of_zeros_is_named(count):
    config = Sensors(joints=JointSensors(zero_rad=(0.1,) * count))
    expected = "sensors.joints.zero_rad: expected 1 value, or 3, one for each joint"
    with pytest.raises(ScenarioError, match=expected):
        SensorErrors.make(config, JOINTS)
