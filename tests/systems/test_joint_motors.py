"""Motors of the joints with a factor on their torques."""

import numpy as np
import pytest

from aerodrake.scenario import Mismatch
from aerodrake.systems.joint_motors import make_joint_motors


def torques(vehicle, scale: float, command) -> np.ndarray:
    motors = make_joint_motors(Mismatch(torque_scale=scale), vehicle)
    context = motors.CreateDefaultContext()
    motors.get_input_port().FixValue(context, command)
    return motors.get_output_port().Eval(context)


def test_there_is_no_system_without_mismatch(vehicle):
    assert make_joint_motors(Mismatch(), vehicle) is None


@pytest.mark.parametrize("scale", [0.1, 1.5, 10.0])
def test_the_deviation_from_trim_is_scaled_within_limits(vehicle, scale):
    trim, limit = vehicle.trim_torque, vehicle.effort
    deviation = 0.05 * limit * np.array([1, -1, 1, -1, 1, -1])
    np.testing.assert_allclose(
        torques(vehicle, scale, trim + deviation), np.clip(trim + scale * deviation, -limit, limit)
    )
    np.testing.assert_allclose(torques(vehicle, scale, trim), trim, atol=1e-15)
    np.testing.assert_allclose(torques(vehicle, scale, 1e6 * np.ones(6)), limit)
